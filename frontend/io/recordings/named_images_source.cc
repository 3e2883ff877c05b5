#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>

#include "frontend/base/number_text.h"
#include "frontend/io/recordings/image_list_source.h"

namespace tagtwist {
namespace {

namespace fs = std::filesystem;
constexpr int64_t kShortestIntervalNs = 100000;  // on average; closer ones are plain numbers

bool IsImageName(const fs::path& path) {
  constexpr std::array<const char*, 7> kExtensions = {".png", ".jpg",  ".jpeg", ".pgm",
                                                      ".bmp", ".tiff", ".tif"};
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return path.filename().string()[0] != '.' &&
         std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

// What follows the last underscore of a name: nanoseconds, or seconds with a dot.
std::optional<int64_t> StampOfName(const fs::path& path) {
  const std::string stem = path.stem().string();
  const std::string text = stem.substr(stem.rfind('_') + 1);  // npos + 1 is 0
  if (text.find_first_not_of("0123456789.") != std::string::npos) return std::nullopt;
  return text.find('.') == std::string::npos ? ParseInteger(text) : ParseSeconds(text);
}

std::vector<fs::path> ImagesIn(const std::string& folder) {
  std::vector<fs::path> out;
  std::error_code unknown;
  for (const auto& entry : fs::directory_iterator(folder, unknown)) {
    if (IsImageName(entry.path())) out.push_back(entry.path());
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

bool HasNamedImages(const std::string& folder) { return !ImagesIn(folder).empty(); }

Result<std::unique_ptr<DataSource>> OpenNamedImagesSource(const std::string& folder,
                                                          const DataSourceOptions& options) {
  const std::string hint = " (nanoseconds, or seconds with a dot; or give a timestamps.csv)";
  std::vector<std::pair<int64_t, fs::path>> images;
  for (const fs::path& path : ImagesIn(folder)) {
    const auto t_ns = StampOfName(path);
    if (!t_ns) return Error{path.string() + ": expected a stamp for a name" + hint};
    images.emplace_back(*t_ns, path);
  }
  std::sort(images.begin(), images.end());
  const auto intervals = static_cast<int64_t>(images.size()) - 1;
  if (intervals > 0 &&
      images.back().first - images.front().first < intervals * kShortestIntervalNs) {
    return Error{folder + ": the images' names are numbers, not stamps" + hint};
  }
  ImageList list;
  for (const auto& [t_ns, path] : images) {
    if (!list.stamps_ns.empty() && t_ns == list.stamps_ns.back()) {
      return Error{path.string() + ": expected each stamp once, got it again"};
    }
    list.stamps_ns.push_back(t_ns);
    list.frames.push_back({path.string(), path.string(), {}});
  }
  if (const Status read = ReadTruthAndImu(folder, &list); !read) return read.error();
  return MakeImageListSource(std::move(list), options);
}

}  // namespace tagtwist
