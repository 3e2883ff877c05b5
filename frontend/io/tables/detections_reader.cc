#include "frontend/io/tables/detections_reader.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <utility>

#include "frontend/io/tables/csv.h"
#include "frontend/io/tables/detections_csv.h"
#include "frontend/io/tables/stamp_unit.h"

namespace tagtwist::internal {

// Where a table has what.
struct TagColumns {
  std::vector<size_t> tag;         // id, u1, v1, ..., u4, v4
  std::vector<size_t> covariance;  // none where the table has none
  std::optional<size_t> doubled;
};

namespace {

// A row's id, one of `known_ids` where these have any.
Result<int> ReadId(const CsvTable& table, size_t row, size_t column,
                   const std::vector<int>& known_ids) {
  const auto id = table.Integer(row, column);
  if (!id) return id.error();
  if (*id < 0 || *id > std::numeric_limits<int>::max()) {
    return table.ErrorAt(row, "id: expected a tag id >= 0, got " + std::to_string(*id));
  }
  const int out = static_cast<int>(*id);
  if (!known_ids.empty() && std::find(known_ids.begin(), known_ids.end(), out) == known_ids.end()) {
    return table.ErrorAt(row, "id: expected a tag of the map, got " + std::to_string(out));
  }
  return out;
}

// Whether a row tells of an id that was seen at two places, and nothing else.
Result<bool> IsOfDoubled(const CsvTable& table, size_t row, const TagColumns& columns) {
  if (!columns.doubled) return false;
  const std::string_view cell = table.Cell(row, *columns.doubled);
  if (cell.empty() || cell == "0" || cell == "1") return cell == "1";
  return table.ErrorAt(row, "doubled: expected 1 or nothing, got " + QuoteForMessage(cell));
}

// The corners of a row's tag, whose id is known.
Result<TagDetection> ReadTag(const CsvTable& table, size_t row, int id,
                             const std::vector<size_t>& columns) {
  TagDetection tag;
  tag.id = id;
  for (size_t corner = 0; corner < 4; ++corner) {
    const auto u = table.Number(row, columns[1 + 2 * corner]);
    if (!u) return u.error();
    const auto v = table.Number(row, columns[2 + 2 * corner]);
    if (!v) return v.error();
    tag.corners[corner] = {*u, *v};
  }
  return tag;
}

Result<TagColumns> FindTagColumns(const CsvTable& table) {
  auto tag = table.RequireColumns({"id", "u1", "v1", "u2", "v2", "u3", "v3", "u4", "v4"});
  if (!tag) return tag.error();
  TagColumns out{std::move(*tag), {}, table.FindColumn("doubled")};
  if (!table.FindColumn("c11")) return out;
  auto covariance = table.RequireColumns(TagCovarianceNames());
  if (!covariance) return covariance.error();
  out.covariance = std::move(*covariance);
  return out;
}

// A covariance that is no positive one would spoil a run.
Status ReadCovariance(const CsvTable& table, size_t row, const std::vector<size_t>& columns,
                      TagDetection* tag) {
  if (columns.empty() || table.Cell(row, columns[0]).empty()) return Ok();
  const auto numbers = table.Numbers(row, columns);
  if (!numbers) return numbers.error();
  Eigen::Matrix<double, 8, 8> covariance;
  size_t next = 0;
  for (int i = 0; i < 8; ++i) {
    for (int j = i; j < 8; ++j) covariance(i, j) = covariance(j, i) = (*numbers)[next++];
  }
  if (covariance.llt().info() != Eigen::Success) {
    return table.ErrorAt(row, "c11 .. c88: expected a positive definite covariance");
  }
  tag->covariance = covariance;
  return Ok();
}

// Adds what a row says to what its stamp has.
Status AddRow(const CsvTable& table, size_t row, const TagColumns& columns,
              const std::vector<int>& known_ids, StampedDetections* out) {
  const auto id = ReadId(table, row, columns.tag[0], known_ids);
  if (!id) return id.error();
  const auto is_doubled = IsOfDoubled(table, row, columns);
  if (!is_doubled) return is_doubled.error();
  if (*is_doubled) {
    const auto place = std::lower_bound(out->doubled_ids.begin(), out->doubled_ids.end(), *id);
    if (place == out->doubled_ids.end() || *place != *id) out->doubled_ids.insert(place, *id);
    return Ok();
  }
  auto tag = ReadTag(table, row, *id, columns.tag);
  if (!tag) return tag.error();
  if (const Status read = ReadCovariance(table, row, columns.covariance, &*tag); !read) return read;
  out->tags.push_back(std::move(*tag));
  return Ok();
}

std::string StampColumnName(TimeUnit unit) {
  return unit == TimeUnit::kSeconds ? "t" : "timestamp";
}

}  // namespace

struct DetectionsReader::Impl {
  Impl(CsvPieces of_file, TimeUnit stamps_unit, std::vector<int> ids)
      : pieces(std::move(of_file)), unit(stamps_unit), known_ids(std::move(ids)) {}

  Status Check();
  Status CheckRows(std::vector<double>* numbers);
  Status Rewind();
  Result<std::optional<StampedDetections>> Next();

  CsvPieces pieces;
  TimeUnit unit;
  std::vector<int> known_ids;
  size_t stamp_column = 0;
  TagColumns columns;
  std::optional<StampUnit> implied;  // by the stamps, against the format
  std::vector<int64_t> stamps_ns;
  std::vector<std::string> notes;

  std::optional<StampColumn> stamps;  // of the rows before `row`
  const CsvTable* piece = nullptr;
  size_t row = 0;                          // of the piece
  std::optional<StampedDetections> begun;  // more rows of it may follow
};

Status DetectionsReader::Impl::Rewind() {
  stamps.emplace(stamp_column, unit, true, implied);
  return pieces.Rewind();
}

// Faults in the order in which a table that is read as a whole shows them: its lines, its columns,
// its stamps, its rows.
Status DetectionsReader::Impl::Check() {
  const auto stamp = pieces.table().RequireColumns({StampColumnName(unit)});
  auto of_tags = stamp ? FindTagColumns(pieces.table()) : Result<TagColumns>(stamp.error());
  if (!of_tags) {
    while (true) {
      const auto next = pieces.Next();
      if (!next) return next.error();
      if (*next == nullptr) return of_tags.error();
    }
  }
  stamp_column = stamp->front();
  columns = std::move(*of_tags);
  std::vector<double> numbers;
  const Status as_declared = CheckRows(&numbers);
  const auto wrong = FindWrongUnit(numbers, DeclaredUnit(unit));
  if (!wrong) return as_declared;
  implied = wrong->implied;
  notes = {WrongUnitNote(pieces.table().path(), *wrong)};
  return CheckRows(nullptr);
}

// `numbers`: the stamps of all rows, of neighbours that are alike one.
Status DetectionsReader::Impl::CheckRows(std::vector<double>* numbers) {
  if (const Status at_start = Rewind(); !at_start) return at_start;
  stamps_ns.clear();
  std::optional<Error> of_stamps, of_rows;
  StampedDetections latest;
  size_t without = 0;
  const auto take = [&](const CsvTable& table, size_t at) {
    const auto t_ns = stamps->Take(table, at);
    if (!t_ns) of_stamps = t_ns.error();
    if (!t_ns || !*t_ns || of_rows) return;
    if (HasNan(table, at, columns.tag)) {
      ++without;
      return;
    }
    if (stamps_ns.empty() || **t_ns != stamps_ns.back()) {
      stamps_ns.push_back(**t_ns);
      latest.tags.clear();
      latest.doubled_ids.clear();
    }
    const Status added = AddRow(table, at, columns, known_ids, &latest);
    if (!added) of_rows = added.error();
  };
  while (true) {
    const auto next = pieces.Next();
    if (!next) return next.error();
    if (*next == nullptr) break;
    for (size_t at = 0; at < (*next)->rows(); ++at) {
      const auto number = numbers ? ParseNumber((*next)->Cell(at, stamp_column)) : std::nullopt;
      if (number && (numbers->empty() || *number != numbers->back())) numbers->push_back(*number);
      if (!of_stamps) take(**next, at);
    }
  }
  if (of_stamps) return *of_stamps;
  const auto passed_over = stamps->Notes(pieces.table().path());
  if (!passed_over) return passed_over.error();
  if (of_rows) return *of_rows;
  notes.insert(notes.end(), passed_over->begin(), passed_over->end());
  if (without > 0) {
    notes.push_back(pieces.table().path() + ": passed over " + std::to_string(without) +
                    " rows without numbers");
  }
  return Ok();
}

Result<std::optional<StampedDetections>> DetectionsReader::Impl::Next() {
  while (true) {
    if (piece == nullptr || row == piece->rows()) {
      const auto next = pieces.Next();
      if (!next) return next.error();
      piece = *next;
      row = 0;
      if (piece == nullptr) return std::exchange(begun, std::nullopt);
    }
    const size_t at = row++;
    const auto t_ns = stamps->Take(*piece, at);
    if (!t_ns) return t_ns.error();
    if (!*t_ns || HasNan(*piece, at, columns.tag)) continue;
    std::optional<StampedDetections> whole;
    if (!begun || begun->t_ns != **t_ns) {
      whole = std::exchange(begun, StampedDetections{**t_ns, piece->line(at), {}});
    }
    const Status added = AddRow(*piece, at, columns, known_ids, &*begun);
    if (!added) return added.error();
    if (whole) return whole;
  }
}

DetectionsReader::DetectionsReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DetectionsReader::DetectionsReader(DetectionsReader&&) noexcept = default;
DetectionsReader& DetectionsReader::operator=(DetectionsReader&&) noexcept = default;
DetectionsReader::~DetectionsReader() = default;

Result<DetectionsReader> DetectionsReader::Open(const std::string& path, TimeUnit unit,
                                                const std::vector<int>& known_ids,
                                                const Limits& limits) {
  auto pieces = CsvPieces::Open(path, limits);
  if (!pieces) return pieces.error();
  auto impl = std::make_unique<Impl>(std::move(*pieces), unit, known_ids);
  if (const Status fine = impl->Check(); !fine) return fine.error();
  if (const Status at_start = impl->Rewind(); !at_start) return at_start.error();
  return DetectionsReader(std::move(impl));
}

std::vector<int64_t> DetectionsReader::TakeStamps() { return std::move(impl_->stamps_ns); }
const std::vector<std::string>& DetectionsReader::notes() const { return impl_->notes; }
Result<std::optional<StampedDetections>> DetectionsReader::Next() { return impl_->Next(); }

Result<std::vector<StampedDetections>> ReadDetectionsCsv(const std::string& path, TimeUnit unit,
                                                         const std::vector<int>& known_ids,
                                                         std::vector<std::string>* notes,
                                                         const Limits& limits) {
  auto reader = DetectionsReader::Open(path, unit, known_ids, limits);
  if (!reader) return reader.error();
  std::vector<StampedDetections> out;
  while (true) {
    auto next = reader->Next();
    if (!next) return next.error();
    if (!*next) break;
    out.push_back(std::move(**next));
  }
  if (notes != nullptr) notes->insert(notes->end(), reader->notes().begin(), reader->notes().end());
  return out;
}

}  // namespace tagtwist::internal
