#include "estimator/publish/image_recorder.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string_view>
#include <system_error>
#include <vector>

#include "frontend/base/format_text.h"
#include "frontend/base/number_text.h"

namespace tagtwist::internal {
namespace {

namespace fs = std::filesystem;

// 0 or errno.
int WriteAll(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes.remove_prefix(static_cast<size_t>(written));
  }
  return 0;
}

int WriteNew(const std::string& path, std::string_view bytes) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) return errno;
  const int failure = WriteAll(descriptor, bytes);
  const int closed = ::close(descriptor) == 0 ? 0 : errno;
  return failure != 0 ? failure : closed;
}

// Packed as little as keeps up with a camera.
std::vector<unsigned char> Png(const cv::Mat& gray) {
  std::vector<unsigned char> out;
  try {
    cv::imencode(".png", gray, out, {cv::IMWRITE_PNG_COMPRESSION, 1});
  } catch (const cv::Exception&) {
    out.clear();
  }
  return out;
}

}  // namespace

Result<std::unique_ptr<ImageRecorder>> ImageRecorder::Create(const std::string& folder) {
  std::error_code failure;
  if (fs::exists(folder, failure) &&
      (!fs::is_directory(folder, failure) || !fs::is_empty(folder, failure))) {
    return Error{folder + ": exists already and is not empty"};
  }
  fs::create_directories(fs::path(folder) / "images", failure);
  if (failure) return Error{folder + ": cannot write: " + failure.message()};
  const std::string table = folder + "/timestamps.csv";
  const int descriptor = ::open(table.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    return Error{table + ": cannot write: " + std::generic_category().message(errno)};
  }
  std::unique_ptr<ImageRecorder> out(new ImageRecorder(folder, descriptor));
  const int written = WriteAll(descriptor, "t,file\n");
  if (written != 0) return out->Fail("timestamps.csv", written).error();
  return out;
}

ImageRecorder::~ImageRecorder() { ::close(table_); }

Status ImageRecorder::Fail(const std::string& file, int failure) {
  failed_ = true;
  return Error{folder_ + "/" + file +
               ": cannot write: " + std::generic_category().message(failure)};
}

Status ImageRecorder::Add(int64_t t_ns, const cv::Mat& gray) {
  if (failed_) return Ok();
  std::string file;
  if (!gray.empty()) {
    file = Format("images/%06zu.png", frames_);
    const std::vector<unsigned char> png = Png(gray);
    const std::string_view bytes(reinterpret_cast<const char*>(png.data()), png.size());
    if (const int failure = WriteNew(folder_ + "/" + file, bytes); failure != 0) {
      return Fail(file, failure);
    }
  }
  const int failure = WriteAll(table_, FormatSeconds(t_ns) + "," + file + "\n");
  if (failure != 0) return Fail("timestamps.csv", failure);
  ++frames_;
  return Ok();
}

}  // namespace tagtwist::internal
