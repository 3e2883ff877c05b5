#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>

#include "frontend/base/number_text.h"
#include "frontend/io/recordings/image_list_source.h"
#include "frontend/io/tables/stamp_unit.h"

namespace tagtwist::internal {
namespace {

namespace fs = std::filesystem;
constexpr double kShortestIntervalS = 1e-4;  // in the median; closer ones are plain numbers

bool IsImageName(const fs::path& path) {
  constexpr std::array<const char*, 7> kExtensions = {".png", ".jpg",  ".jpeg", ".pgm",
                                                      ".bmp", ".tiff", ".tif"};
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return path.filename().string()[0] != '.' &&
         std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

// What follows the last underscore of a name: digits, perhaps with a dot.
std::optional<std::string> NumberOfName(const fs::path& path) {
  const std::string stem = path.stem().string();
  const std::string text = stem.substr(stem.rfind('_') + 1);  // npos + 1 is 0
  if (text.find_first_not_of("0123456789.") != std::string::npos || !ParseNumber(text)) {
    return std::nullopt;
  }
  return text;
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
  const std::vector<fs::path> paths = ImagesIn(folder);
  std::vector<double> numbers;
  bool dots = false;
  for (const fs::path& path : paths) {
    const auto number = NumberOfName(path);
    if (!number) return Error{path.string() + ": expected a stamp for a name" + hint};
    numbers.push_back(*ParseNumber(*number));
    dots = dots || number->find('.') != std::string::npos;
  }
  std::sort(numbers.begin(), numbers.end());
  const StampUnit declared = dots ? StampUnit::kSeconds : StampUnit::kNanoseconds;
  const auto wrong = FindWrongUnit(numbers, declared);
  const bool dated = UnitOfUnixTime(numbers.front()).has_value();
  const bool too_close = MedianStep(numbers) * SecondsIn(declared) < kShortestIntervalS;
  if (numbers.size() > 1 && too_close && !(wrong && dated)) {
    return Error{folder + ": the images' names are numbers, not stamps" + hint +
                 (wrong ? "; " + wrong->words : "")};
  }
  const StampUnit unit = wrong ? wrong->implied : declared;
  std::vector<std::pair<int64_t, fs::path>> images;
  for (const fs::path& path : paths) {
    const auto t_ns = ParseStamp(*NumberOfName(path), unit);
    if (!t_ns) return Error{path.string() + ": expected a stamp for a name" + hint};
    images.emplace_back(*t_ns, path);
  }
  std::sort(images.begin(), images.end());
  ImageList list;
  if (wrong) {
    list.notes.push_back(folder + ": the images' names are taken for " + ToString(unit) + ": " +
                         wrong->words);
  }
  for (const auto& [t_ns, path] : images) {
    if (!list.stamps_ns.empty() && t_ns == list.stamps_ns.back()) {
      list.notes.push_back(path.string() + ": passed over, its stamp is another image's");
      continue;
    }
    list.stamps_ns.push_back(t_ns);
    list.images.push_back(path.string());
  }
  if (const Status read = ReadTruthAndImu(folder, options.limits, &list); !read) {
    return read.error();
  }
  return MakeImageListSource(std::move(list), options);
}

}  // namespace tagtwist::internal
