#include <gtest/gtest.h>

#include "server/log.h"
#include "server/worker.h"
#include "tests/server/test_engine.h"

// The jobs of these tests run in children of this very program.
int main(int argc, char** argv) {
  if (const auto code =
          lightbatch::server::run_worker_if_asked(argc, argv, lightbatch::server::test::engine())) {
    return *code;
  }
  lightbatch::server::configure_log(lightbatch::server::LogLevel::kOff, false);
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
