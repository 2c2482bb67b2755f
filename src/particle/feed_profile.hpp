#pragma once
// The speed over the section of an inflow (docs/theory.md, "Inflow").

#include <array>

#include "grid/face.hpp"
#include "grid/grid_geometry.hpp"

namespace bulkley {

struct DiscSection;
struct RectangleSection;

enum class FeedProfile {
  plug,        ///< the same speed everywhere
  poiseuille,  ///< that of the developed flow of a Newtonian fluid along walls at the section's edge
};

/// Whether there is no wall at an end of a rectangle: its width, below and above, then its height.
using OpenEnds = std::array<std::array<bool, 2>, 2>;

/// The ends of a rectangle at rest that lie on faces of the domain which do not slow down what flows along them: periodic and slip
/// ones. `center`: of the section, m; `first`, `second`: unit vectors along width and height. Not collective.
OpenEnds open_ends(const GridGeometry& grid, const Faces& faces, const RectangleSection& section, const Vec3& center,
                   const Vec3& first, const Vec3& second);

/// Speeds of a developed flow as shares of their mean over the section. Not collective.
class SpeedShares {
 public:
  struct Share {
    double value = 1.0;
    double slope[2] = {0.0, 0.0};  ///< 1/m, along the coordinates of the section
  };

  /// A plug: 1 everywhere.
  SpeedShares() = default;
  explicit SpeedShares(const DiscSection& section);
  SpeedShares(const RectangleSection& section, const OpenEnds& open);

  bool is_plug() const { return kind_ == Kind::plug; }
  double largest() const { return largest_; }
  /// At the point (a, b) of the section, m; 0 on its edge and outside of it, unless all is a plug.
  Share at(double a, double b) const;

 private:
  enum class Kind { plug, disc, plane, duct };
  /// Of the distances x and y from the middle, in half widths of the narrower side: of unit curvature -1, not of unit mean.
  Share duct(double x, double y) const;

  Kind kind_ = Kind::plug;
  double largest_ = 1.0;
  double middle_[2] = {0.0, 0.0};  ///< m, of the flow along width and height
  double half_[2] = {0.0, 0.0};    ///< m, from there to the wall; of a disc the radius
  int narrow_ = 0;                 ///< the side across which a duct is narrower, or a plane flow has walls
  double ratio_ = 1.0;             ///< of the sides of a duct, at least 1
  double mean_ = 1.0;              ///< of what `duct` gives
};

}  // namespace bulkley
