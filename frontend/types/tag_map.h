#pragma once
#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "frontend/types/pose.h"

namespace tagtwist {

/// One printed tag. Tag frame: origin at the centre, x to the right and y up as printed, z out of
/// the paper.
struct Tag {
  int id = -1;
  Pose world_from_tag;
  double size_m = 0;  // side of the black square, > 0
  double bend_m = 0;  // of its paper, a saddle: p1 and p3 lie that much above its plane, p2 and p4
                      // below; less than a quarter of the side
};

/// Corners p1..p4 of a tag in W [m]: bottom-left, bottom-right, top-right, top-left as printed.
/// world_from_tag * (-+ size / 2, -+ size / 2, +- bend).
std::array<Eigen::Vector3d, 4> TagCornersInWorld(const Tag& tag);
/// The rule that a tag's bend breaks, or nullopt.
std::optional<std::string> BendProblem(const Tag& tag);

/// Where the tags are. Immutable once made; look-up by id.
class TagMap {
 public:
  TagMap() = default;
  /// Keeps the order of the list. Check Problem() before use.
  TagMap(std::string family, std::vector<Tag> tags);

  const std::string& family() const { return family_; }
  const std::vector<Tag>& tags() const { return tags_; }
  /// nullptr when the map has no such tag.
  const Tag* Find(int id) const;
  /// World corners p1..p4 of a tag in the map; the id must be in it.
  const std::array<Eigen::Vector3d, 4>& CornersInWorld(int id) const;
  /// The broken rule (no tag, an id twice, a size that is not positive, a bend out of range), or
  /// nullopt.
  std::optional<std::string> Problem() const;

 private:
  std::string family_ = "tag36h11";
  std::vector<Tag> tags_;
  std::vector<std::array<Eigen::Vector3d, 4>> corners_;
  std::unordered_map<int, size_t> index_;
};

/// Tags that move together, in the frame of the body that carries them.
struct TaggedBody {
  std::string name;  // letters, digits, - and _: files are called after it
  TagMap map;
};

/// A mat of rows x columns equal tags in the plane z = 0, all upright: x runs down the rows, y to
/// the right over the columns, z out of the paper; the world origin is the top-left corner of the
/// first tag. id = first_id + rows * column + row. Defaults: the course's mat.
struct TagGrid {
  std::string family = "tag36h11";
  int first_id = 0;
  int rows = 12, columns = 9;
  double tag_size_m = 0.152;
  std::vector<double> row_gaps_m = std::vector<double>(11, 0.152);  // rows - 1 of them
  std::vector<double> column_gaps_m = {0.152, 0.152, 0.178, 0.152,
                                       0.152, 0.178, 0.152, 0.152};  // columns - 1 of them
  std::optional<std::string> Problem() const;
};
TagMap MakeTagMap(const TagGrid& grid);

}  // namespace tagtwist
