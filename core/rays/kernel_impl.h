// Casting loops over the 8-wide tree; included once by each kernel_*.cpp with its instruction set
// switched on, inside an anonymous namespace.
//
// Boxes: slab test with all rounding errors folded into the two offsets of each axis (near planes
// see the origin moved one way, far planes the other, by more than any rounding of coordinates,
// inverses and products), after the idea of T. Ize, Robust BVH Ray Traversal, JCGT 2(2), 2013.
// Boxes so gain thickness: flat ones and axis-parallel rays need no special case.
// Triangles: Woop's test in float, eight at once, with a bound on its error; only triangles that it
// cannot rule out go to ExactTest. Grids offer the leaves near a ray in place of boxes. Segments
// that run together share the way through the tree.

// Each needs those before it.
// clang-format off
#include "core/rays/kernel_vectors.h"
#include "core/rays/kernel_ray.h"
#include "core/rays/kernel_leaf.h"
#include "core/rays/kernel_grid.h"
#include "core/rays/kernel_single.h"
#include "core/rays/kernel_wide.h"
#include "core/rays/kernel_packet.h"
#include "core/rays/kernel_bundle.h"
// clang-format on
