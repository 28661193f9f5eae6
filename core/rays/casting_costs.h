#pragma once

namespace lightbatch::rays {

// What a ray's steps cost, in visits of a wide node; tuned by timing rays in furnished rooms, those
// of grids also in even swarms of triangles.
constexpr float kNodeCost = 1.0f;
constexpr float kLeafCost = 0.7f;
constexpr float kTriangleCost = 0.06f;  // one more in a leaf
constexpr float kGridCost = 6.0f;       // entering a grid
constexpr float kCellCost = 0.6f;       // passing through a cell
constexpr float kMemberCost = 0.2f;     // a reference to a leaf in it
constexpr float kGridLeafCost = 1.4f;   // the leaf itself: nothing has sent for it before

}  // namespace lightbatch::rays
