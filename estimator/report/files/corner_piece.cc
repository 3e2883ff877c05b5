#include "estimator/report/files/corner_piece.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "estimator/report/files/summary_json.h"
#include "frontend/base/files/file_set.h"
#include "frontend/base/files/input_file.h"
#include "frontend/io/tables/detections_reader.h"

namespace tagtwist::internal {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int64_t kMostPieceBytes = 1 << 16;

// A piece, and where it is.
struct PlacedPiece {
  fs::path folder;
  CornerPiece piece;
};

std::vector<fs::path> PieceFolders(const std::string& folder) {
  std::error_code unknown;
  std::vector<fs::path> out;
  const auto add = [&](const fs::path& place) {
    if (fs::is_regular_file(place / "piece.json", unknown)) out.push_back(place);
  };
  add(folder);
  for (fs::directory_iterator entry(folder, unknown), end; !unknown && entry != end;
       entry.increment(unknown)) {
    add(entry->path());
  }
  std::sort(out.begin(), out.end());
  return out;
}

template <typename Number>
bool ReadWhole(const Json& json, const char* key, Number* out) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_number_integer()) return false;
  *out = found->get<Number>();
  return true;
}

Result<CornerPiece> ReadPiece(const fs::path& path) {
  const auto text = ReadWholeFile(path.string(), kMostPieceBytes);
  if (!text) return text.error();
  const Json json = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  CornerPiece out;
  const bool is_whole =
      json.is_object() && json.value("measured_with", Json()).is_string() &&
      json.value("version", Json()).is_string() && ReadWhole(json, "frames", &out.frames) &&
      ReadWhole(json, "from", &out.from) && ReadWhole(json, "to", &out.to) &&
      ReadWhole(json, "first_ns", &out.first_ns) && ReadWhole(json, "last_ns", &out.last_ns);
  if (!is_whole) return Error{path.string() + ": expected what --only_detections writes"};
  out.measured_with = json["measured_with"].get<std::string>();
  const auto version = json["version"].get<std::string>();
  if (version == TAGTWIST_VERSION) return out;
  return Error{path.string() + ": measured by version " + version +
               ", this is " TAGTWIST_VERSION ": measure it again"};
}

Status CheckPiece(const std::string& path, const CornerPiece& piece, const CornerPiece& wanted) {
  if (piece.frames != wanted.frames || piece.first_ns != wanted.first_ns ||
      piece.last_ns != wanted.last_ns) {
    return Error{path + ": is of another recording: it has " + std::to_string(piece.frames) +
                 " frames, " + wanted.dataset + " has " + std::to_string(wanted.frames) +
                 ", or their stamps differ"};
  }
  if (piece.measured_with == wanted.measured_with) return Ok();
  return Error{path + ": measured with another camera, map or detector: measure it again"};
}

// Each frame once.
Status CheckCover(const std::string& folder, std::vector<PlacedPiece> pieces, size_t frames) {
  std::sort(pieces.begin(), pieces.end(),
            [](const PlacedPiece& a, const PlacedPiece& b) { return a.piece.from < b.piece.from; });
  size_t reached = 0, fitting = 0;
  for (const PlacedPiece& placed : pieces) {
    if (placed.piece.from != reached || placed.piece.to <= reached) break;
    reached = placed.piece.to;
    ++fitting;
  }
  if (fitting == pieces.size() && reached == frames) return Ok();
  return Error{folder + ": its " + std::to_string(pieces.size()) +
               " pieces have not each frame once: expected one that begins at frame " +
               std::to_string(reached) + " of " + std::to_string(frames)};
}

Status AddCorners(const fs::path& folder, MeasuredTags* out) {
  auto rows = ReadDetectionsCsv((folder / "detections.csv").string(), TimeUnit::kSeconds);
  if (!rows) return rows.error();
  for (StampedDetections& stamped : *rows) {
    (*out)[stamped.t_ns] = {std::move(stamped.tags), std::move(stamped.doubled_ids)};
  }
  return Ok();
}

}  // namespace

OutputSet PieceSet(const std::string& folder) {
  return {folder, {"piece.json", "detections.csv"}, {}, {"piece.json", "detections.csv"}};
}

Status WritePiece(const std::string& folder, const CornerPiece& piece,
                  const std::string& detections_csv) {
  auto set = FileSet::Begin(folder);
  if (!set) return set.error();
  const Json json = {{"dataset", piece.dataset}, {"measured_with", piece.measured_with},
                     {"frames", piece.frames},   {"from", piece.from},
                     {"to", piece.to},           {"first_ns", piece.first_ns},
                     {"last_ns", piece.last_ns}, {"version", TAGTWIST_VERSION}};
  if (auto added = (*set)->Add("piece.json", FormatJson(json)); !added) return added;
  if (auto added = (*set)->Add("detections.csv", detections_csv); !added) return added;
  return (*set)->Commit();
}

std::vector<std::string> FilesOfPieces(const std::string& folder) {
  std::vector<std::string> out;
  for (const fs::path& place : PieceFolders(folder)) {
    for (const char* name : {"piece.json", "detections.csv"}) {
      out.push_back((place / name).string());
    }
  }
  return out;
}

Result<MeasuredTags> ReadPieces(const std::string& folder, const CornerPiece& wanted) {
  std::vector<PlacedPiece> pieces;
  for (const fs::path& place : PieceFolders(folder)) {
    if (!IsFileSetWhole(place.string())) {
      return Error{place.string() +
                   ": a run was ended while it wrote this piece: measure it again"};
    }
    const auto piece = ReadPiece(place / "piece.json");
    if (!piece) return piece.error();
    const std::string path = (place / "piece.json").string();
    if (const Status fits = CheckPiece(path, *piece, wanted); !fits) return fits.error();
    pieces.push_back({place, *piece});
  }
  if (pieces.empty()) return Error{folder + ": holds no pieces (--only_detections writes them)"};
  if (const Status whole = CheckCover(folder, pieces, wanted.frames); !whole) return whole.error();
  MeasuredTags out;
  for (const PlacedPiece& placed : pieces) {
    if (const Status added = AddCorners(placed.folder, &out); !added) return added.error();
  }
  return out;
}

}  // namespace tagtwist::internal
