#pragma once

#include <span>

#include "core/hierarchy/builder.h"

namespace lightbatch::hierarchy {

/// The founding algorithm in plain scalar code, which the builder equals bit for bit. n >= 1.
TreeArrays sweep_reference(std::span<const Aabb> boxes);

}  // namespace lightbatch::hierarchy
