#include "frontend/io/mat/mat_contents.h"

namespace tagtwist::internal {

size_t MatArray::size() const {
  return kind == Kind::kNumbers ? numbers.size() : kind == Kind::kBytes ? bytes.size() : 0;
}

bool MatArray::IsMatrix(size_t rows, size_t columns) const {
  return kind != Kind::kOther && dims == std::vector<size_t>{rows, columns};
}

std::vector<double> MatArray::ToNumbers() const {
  return kind == Kind::kBytes ? std::vector<double>(bytes.begin(), bytes.end()) : numbers;
}

std::string DescribeShape(const MatArray& array) {
  if (array.kind == MatArray::Kind::kOther) return "not a real array";
  std::string out;
  for (const size_t side : array.dims) out += (out.empty() ? "" : " x ") + std::to_string(side);
  return out;
}

}  // namespace tagtwist::internal
