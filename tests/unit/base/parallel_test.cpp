#include "core/base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <mutex>
#include <set>
#include <thread>

#include "core/base/random.h"

namespace lightbatch {
namespace {

class ParallelTest : public testing::TestWithParam<int> {
 protected:
  void SetUp() override { set_thread_count(GetParam()); }
  void TearDown() override { set_thread_count(1); }
};
INSTANTIATE_TEST_SUITE_P(Threads, ParallelTest, testing::Values(1, 2, 3, 8));

TEST_P(ParallelTest, EmptyRangesCallNothing) {
  parallel_for(0, 16, [](std::size_t, std::size_t) { FAIL(); });
  parallel_tasks(std::vector<int>(), [] { return [](int, std::vector<int>&) { FAIL(); }; });
  const int value = deterministic_reduce(
      0, 16, 7, [](std::size_t, std::size_t) { return 1; }, [](int a, int b) { return a + b; });
  EXPECT_EQ(value, 7);
}

TEST_P(ParallelTest, EachItemIsVisitedOnceInBlocksOfTheGrain) {
  for (const std::size_t count : {1u, 15u, 16u, 17u, 1000u}) {
    for (const std::size_t grain : {1u, 16u, 5000u}) {
      std::vector<std::atomic<int>> visits(count);
      parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
        EXPECT_LT(begin, end);
        EXPECT_LE(end - begin, grain);
        EXPECT_EQ(begin % grain, 0u);
        for (std::size_t i = begin; i < end; ++i) ++visits[i];
      });
      for (const auto& visit : visits) ASSERT_EQ(visit, 1);
    }
  }
}

TEST_P(ParallelTest, GrainOfZeroIsTakenAsOne) {
  std::atomic<int> blocks{0};
  parallel_for(5, 0, [&](std::size_t begin, std::size_t end) {
    EXPECT_EQ(end - begin, 1u);
    ++blocks;
  });
  EXPECT_EQ(blocks, 5);
}

TEST_P(ParallelTest, NestedLoopsRunToTheEnd) {
  std::vector<std::atomic<int>> visits(64 * 64);
  parallel_for(64, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      parallel_for(64, 4, [&](std::size_t first, std::size_t last) {
        for (std::size_t j = first; j < last; ++j) ++visits[i * 64 + j];
      });
    }
  });
  for (const auto& visit : visits) ASSERT_EQ(visit, 1);
}

TEST_P(ParallelTest, TasksAndThoseThatFollowRunOnceEach) {
  // Task i brings up 2 i and 2 i + 1.
  constexpr int kEnd = 1000;
  std::vector<std::atomic<int>> runs(kEnd);
  std::atomic<std::size_t> bodies{0};
  parallel_tasks(std::vector<int>{1}, [&] {
    ++bodies;
    return [&](int task, std::vector<int>& more) {
      ++runs[static_cast<std::size_t>(task)];
      for (const int next : {2 * task, 2 * task + 1}) {
        if (next < kEnd) more.push_back(next);
      }
    };
  });
  for (std::size_t i = 1; i < runs.size(); ++i) ASSERT_EQ(runs[i], 1);
  EXPECT_LE(bodies, static_cast<std::size_t>(GetParam()));
}

TEST(Parallel, OneThreadTakesTheLargestTaskFirst) {
  set_thread_count(1);
  std::vector<int> order;
  parallel_tasks(std::vector<int>{3, 9, 5}, [&] {
    return [&](int task, std::vector<int>& more) {
      order.push_back(task);
      if (task == 9) more = {4, 1};
    };
  });
  EXPECT_EQ(order, (std::vector<int>{9, 5, 4, 3, 1}));
}

TEST_P(ParallelTest, ManyShortLoopsInARow) {
  std::atomic<std::size_t> sum{0};
  for (int loop = 0; loop < 3000; ++loop) {
    parallel_for(7, 2, [&](std::size_t begin, std::size_t end) { sum += end - begin; });
  }
  EXPECT_EQ(sum, 3000u * 7);
}

double sum_of_hard_numbers() {
  constexpr std::size_t kCount = 100'000;
  return deterministic_reduce(
      kCount, 97, 0.0,
      [](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) {
          Random random(item_seed(11, i));
          sum += std::exp(40 * random.next_double() - 20);
        }
        return sum;
      },
      [](double a, double b) { return a + b; });
}

TEST_P(ParallelTest, ReductionGivesTheSameBitsOnAnyNumberOfThreads) {
  const double here = sum_of_hard_numbers();
  EXPECT_EQ(here, sum_of_hard_numbers()) << "two runs";
  set_thread_count(1);
  EXPECT_EQ(here, sum_of_hard_numbers()) << "one thread";
}

TEST(Parallel, FoldKeepsTheOrderOfBlocks) {
  set_thread_count(4);
  const std::vector<std::size_t> order = deterministic_reduce(
      1000, 10, std::vector<std::size_t>(),
      [](std::size_t begin, std::size_t) { return std::vector<std::size_t>{begin}; },
      [](std::vector<std::size_t> all, std::vector<std::size_t> block) {
        all.insert(all.end(), block.begin(), block.end());
        return all;
      });
  ASSERT_EQ(order.size(), 100u);
  for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], i * 10);
  set_thread_count(1);
}

TEST(Parallel, UsesTheThreadsItMay) {
  set_thread_count(2);
  // Two tasks that wait for each other finish only on two threads.
  std::atomic<int> arrived{0};
  parallel_for(2, 1, [&](std::size_t, std::size_t) {
    ++arrived;
    while (arrived < 2) std::this_thread::yield();
  });
  EXPECT_EQ(arrived, 2);
  EXPECT_EQ(thread_count(), 2);
  set_thread_count(0);
  EXPECT_EQ(thread_count(), 1) << "at least one";
  set_thread_count(1);
}

}  // namespace
}  // namespace lightbatch
