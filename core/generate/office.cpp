#include "core/generate/office.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <span>
#include <utility>

#include "core/generate/assembly.h"
#include "core/generate/materials.h"
#include "core/generate/shell.h"

namespace lightbatch::generate {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kBookRowKinds = 6;         // different rows of each number of books
constexpr std::uint64_t kBook = 12;      // triangles
constexpr double kWorkplaceShare = 0.4;  // most of a room's triangles that one workplace may take

/// Models of one level of detail, in the order of Kind.
enum Kind : std::size_t {
  kDesk,
  kChair,
  kShelf,
  kMonitor,
  kKeyboard,
  kMug,
  kBin,
  kPlant,
  kLampPanelWarm,
  kLampPanelCool,
  kKinds,
};

std::vector<Model> make_models(int detail, std::uint64_t seed) {
  return {make_desk(detail),
          make_chair(detail),
          make_shelf(detail),
          make_monitor(detail),
          make_keyboard(detail),
          make_mug(detail),
          make_bin(detail),
          make_plant(detail, Random(item_seed(seed, 0, kPlant))),
          make_lamp(detail, kLampWarm),
          make_lamp(detail, kLampCool)};
}

/// Where a piece may stand in a room's frame.
struct Item {
  Kind kind = kDesk;
  Vec3d place;
  double yaw = 0;
};

int shelf_count(double width) {
  return static_cast<int>((width - kDoorEnd - 0.25) / (kShelfWidth + 0.02));
}

/// All that a room can hold, what matters most first.
std::vector<Item> items_of(double width, Kind lamp) {
  std::vector<Item> items;
  const double quarter = width / 4, lamp_height = kRoomHeight;
  const auto workplace = [&](double x, double z) {
    items.push_back({kDesk, {x, 0, z}, 0});
    items.push_back({kChair, {x, 0, z + 0.62}, 0});
    items.push_back({kMonitor, {x, kDeskHeight, z - 0.2}, 0});
    items.push_back({kKeyboard, {x, kDeskHeight, z + 0.2}, 0});
    items.push_back({kMug, {x + 0.45, kDeskHeight, z + 0.12}, 0});
  };
  const auto shelf = [&](int i) {
    const double x = -width / 2 + kDoorEnd + 0.15 + (kShelfWidth + 0.02) * (i + 0.5);
    items.push_back({kShelf, {x, 0, kRoomDepth / 2 - kShelfDepth / 2 - 0.01}, kPi});
  };
  items.push_back({lamp, {-quarter, lamp_height, -1.1}, 0});
  workplace(-quarter, -1.9);
  shelf(0);
  items.push_back({lamp, {quarter, lamp_height, -1.1}, 0});
  workplace(quarter, -1.9);
  items.push_back({kBin, {0, 0, -1.9}, 0});
  items.push_back({kPlant, {width / 2 - 0.33, 0, 1.5}, 0.3});
  shelf(1);
  workplace(-quarter, 0.1);
  items.push_back({lamp, {-quarter, lamp_height, 1.1}, 0});
  workplace(quarter, 0.1);
  items.push_back({lamp, {quarter, lamp_height, 1.1}, 0});
  for (int i = 2; i < shelf_count(width); ++i) shelf(i);
  return items;
}

std::uint64_t capacity_of(double width, std::span<const std::uint64_t> sizes) {
  std::uint64_t sum = 0;
  for (const Item& item : items_of(width, kLampPanelWarm)) sum += sizes[item.kind];
  return sum + static_cast<std::uint64_t>(shelf_count(width)) * kShelfBoards * kBooksInRow * kBook;
}

/// Triangles of each kind at one level of detail.
std::vector<std::uint64_t> sizes_of(const std::vector<Model>& models) {
  std::vector<std::uint64_t> sizes;
  for (const Model& model : models) sizes.push_back(model.triangles());
  return sizes;
}

std::uint64_t workplace_size(std::span<const std::uint64_t> sizes) {
  return sizes[kDesk] + sizes[kChair] + sizes[kMonitor] + sizes[kKeyboard] + sizes[kMug] +
         sizes[kShelf];
}

/// Furnishes rooms within a number of triangles each.
class Furnisher {
 public:
  Furnisher(Assembly& assembly, const std::vector<Model>& models, std::uint64_t seed)
      : assembly_(assembly), sizes_(sizes_of(models)), seed_(seed) {
    for (const Model& model : models) models_.push_back(assembly.add_model(model));
  }

  /// Spends at most `budget` triangles below `parent`, and all but a book's worth of it when the
  /// room can hold that much.
  void furnish(Assembly::NodeId parent, const Space& room, std::uint64_t index,
               std::uint64_t budget) {
    Random random(item_seed(seed_, index, 1));
    const Kind lamp = random.below(2) == 0 ? kLampPanelWarm : kLampPanelCool;
    const int fabric = static_cast<int>(random.below(kVariants));
    const int wood = static_cast<int>(random.below(kVariants));
    std::vector<Vec3d> shelves;
    std::map<Kind, int> placed;
    for (const Item& item : items_of(room.width(), lamp)) {
      const std::uint64_t size = sizes_[item.kind];
      if (size > budget) continue;
      budget -= size;
      if (item.kind == kShelf) shelves.push_back(item.place);
      // Chairs are never straight, and desks not quite.
      const bool loose = item.kind == kChair || item.kind == kMug || item.kind == kPlant;
      const double turn = (loose ? 0.5 : 0.0) * (random.next_double() - 0.5);
      const int variant = item.kind == kChair ? fabric : wood;
      const std::string name =
          room.name + " " + kNames[item.kind] + " " + std::to_string(++placed[item.kind]);
      assembly_.add_mesh_node(parent, name, assembly_.mesh(models_[item.kind], variant), item.place,
                              item.yaw + turn);
    }
    fill_shelves(parent, room, shelves, random, budget);
  }

 private:
  void fill_shelves(Assembly::NodeId parent, const Space& room, const std::vector<Vec3d>& shelves,
                    Random random, std::uint64_t budget) {
    int row = 0;
    for (const Vec3d& shelf : shelves) {
      for (int board = 0; board < kShelfBoards && budget >= kBook; ++board) {
        const auto books = std::min<std::uint64_t>(kBooksInRow, budget / kBook);
        budget -= books * kBook;
        const Vec3d place = shelf + Vec3d{0, board_height(board), 0};
        assembly_.add_mesh_node(parent, room.name + " books " + std::to_string(++row),
                                book_row(static_cast<int>(books), random.below(kBookRowKinds)),
                                place, kPi);
      }
    }
  }

  std::size_t book_row(int books, std::uint64_t kind) {
    const auto key = std::pair(books, kind);
    if (const auto found = book_rows_.find(key); found != book_rows_.end()) return found->second;
    const std::uint64_t item = static_cast<std::uint64_t>(books) * kBookRowKinds + kind;
    const Model model = make_books(books, Random(item_seed(seed_, item, 2)));
    return book_rows_[key] = assembly_.mesh(assembly_.add_model(model), 0);
  }

  static constexpr const char* kNames[kKinds] = {"desk", "chair", "shelf", "monitor", "keyboard",
                                                 "mug",  "bin",   "plant", "lamp",    "lamp"};
  Assembly& assembly_;
  std::vector<std::uint64_t> sizes_;
  std::vector<Assembly::ModelId> models_;
  std::map<std::pair<int, std::uint64_t>, std::size_t> book_rows_;
  std::uint64_t seed_;
};

/// Size of the building and detail of its furniture for a number of triangles.
struct Plan {
  Building building;
  std::vector<Model> models;
  std::uint64_t shell_triangles = 0;
};

Plan make_plan(std::uint64_t triangles, std::uint64_t seed) {
  Plan plan;
  // Larger offices have more rooms and finer furniture: rooms grow as the power 0.78.
  double rooms = std::max(1.0, 0.5 * std::pow(static_cast<double>(triangles) / 1000, 0.78));
  while (true) {
    plan.building = make_building(static_cast<int>(rooms), Random(item_seed(seed, 0)));
    plan.shell_triangles = 0;
    for (const Model& shell : plan.building.shells) plan.shell_triangles += shell.triangles();
    const auto count = static_cast<std::uint64_t>(
        std::count_if(plan.building.spaces.begin(), plan.building.spaces.end(),
                      [](const Space& space) { return !space.corridor; }));
    const std::uint64_t share =
        triangles > plan.shell_triangles ? (triangles - plan.shell_triangles) / count : 0;
    for (int detail = kMostDetail; detail >= 0; --detail) {
      plan.models = make_models(detail, seed);
      const double workplace = static_cast<double>(workplace_size(sizes_of(plan.models)));
      if (workplace <= kWorkplaceShare * static_cast<double>(share)) break;
    }
    const std::uint64_t capacity = capacity_of(kNarrowestRoom, sizes_of(plan.models));
    if (static_cast<double>(share) <= 0.95 * static_cast<double>(capacity)) return plan;
    rooms *= 1.15;
    rooms += 1;
  }
}

}  // namespace

Result<Bytes> office_glb(std::uint64_t triangles, std::uint64_t seed) {
  if (triangles < kFewestTriangles || triangles > kMostTriangles) {
    return bad_option("an office has " + std::to_string(kFewestTriangles) + " to " +
                      std::to_string(kMostTriangles) + " triangles; asked for " +
                      std::to_string(triangles));
  }
  Plan plan = make_plan(triangles, seed);
  const std::vector<Space>& spaces = plan.building.spaces;
  Assembly assembly;
  Furnisher furnisher(assembly, plan.models, seed);
  const auto office = assembly.add_group(Assembly::kRoot, "office", {}, 0);

  Random paint(item_seed(seed, 1));
  std::vector<Assembly::NodeId> floors;
  for (std::size_t i = 0; i < plan.building.shells.size(); ++i) {
    const bool outside = i == spaces.size();
    while (!outside && floors.size() <= static_cast<std::size_t>(spaces[i].floor)) {
      const std::string name = "floor " + std::to_string(floors.size());
      floors.push_back(assembly.add_group(office, name, {}, 0));
    }
    const Model& shell = plan.building.shells[i];
    const int colour = outside ? 0 : static_cast<int>(paint.below(kVariants));
    assembly.add_mesh_node(outside ? office : floors[static_cast<std::size_t>(spaces[i].floor)],
                           shell.name, assembly.mesh(assembly.add_model(shell), colour), {}, 0);
  }

  auto rooms_left = static_cast<std::uint64_t>(std::count_if(
      spaces.begin(), spaces.end(), [](const Space& space) { return !space.corridor; }));
  for (std::size_t i = 0; i < spaces.size(); ++i) {
    const Space& space = spaces[i];
    const auto floor = floors[static_cast<std::size_t>(space.floor)];
    const auto group = assembly.add_group(floor, space.corridor ? space.name : "room " + space.name,
                                          space.floor_centre(), space.yaw);
    if (space.corridor) {
      const int pendants = std::max(1, static_cast<int>(space.width() / 9));
      for (int k = 0; k < pendants; ++k) {
        const double x = space.width() * ((k + 0.5) / pendants - 0.5);
        assembly.add_point_light(group, space.name + " pendant " + std::to_string(k + 1),
                                 {x, kRoomHeight - 0.4, 0});
      }
      continue;
    }
    const std::uint64_t done = assembly.drawn_triangles();
    const std::uint64_t budget = done < triangles ? (triangles - done) / rooms_left : 0;
    furnisher.furnish(group, space, i, budget);
    --rooms_left;
  }
  return assembly.finish();
}

}  // namespace lightbatch::generate
