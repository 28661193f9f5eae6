#pragma once

#include "core/rays/caster.h"
#include "core/rays/kernel.h"
#include "core/rays/wide_tree.h"

namespace lightbatch::rays {

struct Caster::Tree {
  WideTree wide;
  const Kernel* kernel;
};

}  // namespace lightbatch::rays
