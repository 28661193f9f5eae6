#pragma once

#include "server/engine.h"

namespace lightbatch::server::test {

/// Jobs whose scene's text says what they do:
///   ok          writes result.txt (the scene's text) and report.html
///   missed      the same, verdict missed target
///   malformed   fails with INPUT_MALFORMED at scene.gltf#/nodes/3
///   slow        reports progress until cancelled
///   deaf        hangs and does not look at cancel
///   crash       dies of SIGSEGV
///   abort       a broken invariant
///   exit        ends without a word
///   oom         allocates without end
///   oom-thread  runs out of memory on another thread
///   sleep MS    takes so long, then as ok
///   limits      writes its limits and environment into result.txt
Engine engine();

}  // namespace lightbatch::server::test
