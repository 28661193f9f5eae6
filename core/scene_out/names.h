#pragma once

#include <string>

namespace lightbatch::scene_out {

/// Names of the nodes that draw batches and instance cells of a plan, by their place in it.
inline std::string batch_name(std::size_t batch) { return "batch_" + std::to_string(batch); }
inline std::string cell_name(std::size_t cell) { return "cell_" + std::to_string(cell); }

}  // namespace lightbatch::scene_out
