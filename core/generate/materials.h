#pragma once

#include <nlohmann/json.hpp>

namespace lightbatch::generate {

/// Materials of the office. Paints, fabrics, woods and book covers come in kVariants colours each:
/// base + variant.
enum Material : int {
  kFacade,
  kCarpet,
  kTiles,
  kCeiling,
  kPlastic,
  kSteel,
  kScreen,
  kSoil,
  kLeaf,
  kPorcelain,
  kLampWarm,
  kLampCool,
  kPaint,
  kFabric = kPaint + 4,
  kWood = kFabric + 4,
  kCover = kWood + 4,
  kMaterialCount = kCover + 4,
};
inline constexpr int kVariants = 4;

/// The glTF material array, indexed by Material. Reflectances are linear Rec. 709, as measured for
/// such things; lamp panels emit 3,500 nits (about 4,000 lm from a panel of 1.2 m x 0.3 m).
nlohmann::json material_table();

}  // namespace lightbatch::generate
