#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace kantaro::perception {

/// Rays of a polar picture, one each 2.5°.
inline constexpr int kDirections = 144;

/// Unit vectors in the image (x right, y down), clockwise from the crown.
[[nodiscard]] const std::array<cv::Point2d, kDirections>& Directions();

/// Directions in which a ring has one sign, group by group.
using Groups = std::vector<std::vector<int>>;

/// The strongest circle of one radius.
struct BestCircle {
  double contrast{};  ///< mean over the groups' directions, each group's sum without its sign
  cv::Point offset;   ///< of the circle's centre from the principal point
};

/// The radii that the votes are counted for, as columns of a polar picture.
struct VoteColumns {
  int radius_of_first_px{};  ///< of column 0
  int pad{};                 ///< columns pad … last; the picture goes on for `pad` after the last
  int last{};
};

/// Hough transform for circles: which centre within `search_px` of the principal point has most
/// votes, for each radius. Where each direction's votes for a centre lie follows from geometry
/// alone, so it is worked out once. Neighbouring directions are shifted nearly alike by any centre:
/// the sums of four of them are formed once for the few ways in which they differ, and shared.
class RingVotes {
 public:
  RingVotes(const Groups& groups, int search_px, const VoteColumns& columns);

  /// @param contrast  CV_32F, a row for each direction; at most ±0.4, so that sums fit 16 bits.
  /// @param visible   directions of the groups that are visible, column by column.
  /// @returns one entry for each column from pad to last.
  [[nodiscard]] std::vector<BestCircle> Count(const cv::Mat& contrast,
                                              const std::vector<int>& visible) const;

 private:
  static constexpr int kShared = 4;  ///< directions whose sums are shared
  /// Up to kShared neighbouring directions of a group.
  struct Block {
    std::vector<int> directions;
    std::vector<std::array<int, kShared>> patterns;  ///< shifts against the first direction's
    int first_row{};                                 ///< of its patterns in the table of sums
  };
  /// The shift of a row depends a little on the radius: bands of radii share one.
  struct Band {
    int begin{}, end{};
    std::vector<Block> blocks;  ///< group by group
    int rows{};                 ///< of the table of sums
    std::vector<int> places;    ///< of a centre's sums in the table, centre by centre, by block
  };

  [[nodiscard]] Band MakeBand(int begin, int end) const;
  [[nodiscard]] int Width(const Band& band) const;
  /// Columns of zeros beside the votes: no two shifts differ by more.
  [[nodiscard]] int Margin() const { return 2 * columns_.pad; }
  [[nodiscard]] std::vector<std::int16_t> Share(const Band& band, const cv::Mat& votes) const;
  void Vote(const Band& band, const std::vector<std::int16_t>& sums,
            std::vector<std::int16_t>& most, std::vector<std::int16_t>& centre) const;

  Groups groups_;
  VoteColumns columns_;
  std::vector<cv::Point> centres_;
  std::vector<std::size_t> blocks_of_group_;
  std::vector<Band> bands_;
};

}  // namespace kantaro::perception
