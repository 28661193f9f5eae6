#include "server/retention.h"

#include <algorithm>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "lightbatch/v1/job_service.pb.h"
#include "lightbatch/v1/scene_service.pb.h"
#include "server/job_store.h"
#include "server/names.h"
#include "server/timestamps.h"

namespace lightbatch::server {
namespace {

struct JobRow {
  std::int64_t number = 0;
  std::string scene;
  bool ended = false;
  double age = 0;  // seconds since its end
  std::vector<v1::Digest> files;
};

struct SceneRow {
  std::int64_t number = 0;
  double age = 0;  // seconds since it was last made, or its files asked for
  bool needed = false;
  std::vector<v1::Digest> files;
};

/// What stays; blobs count once.
class Keeper {
 public:
  explicit Keeper(const Retention& retention) : retention_(retention) {}

  /// Called from new to old: once the room is used up, nothing older stays.
  bool keeps(double age, const std::vector<v1::Digest>& files) {
    if (age < retention_.grace_seconds) return true;
    if (retention_.keep_seconds > 0 && age > retention_.keep_seconds) return false;
    if (retention_.max_bytes > 0 && bytes_ + bytes_beyond(files) > retention_.max_bytes) {
      full_ = true;
    }
    return !full_;
  }
  void add(const std::vector<v1::Digest>& files) {
    for (const v1::Digest& file : files) {
      if (named_.insert(file.sha256()).second) bytes_ += file.size_bytes();
    }
  }
  const std::set<std::string>& named() const { return named_; }

 private:
  std::int64_t bytes_beyond(const std::vector<v1::Digest>& files) const {
    std::int64_t bytes = 0;
    for (const v1::Digest& file : files) {
      if (!named_.contains(file.sha256())) bytes += file.size_bytes();
    }
    return bytes;
  }

  const Retention& retention_;
  std::set<std::string> named_;
  std::int64_t bytes_ = 0;
  bool full_ = false;
};

Status damaged() {
  return Status(StatusCode::kDataLoss, "STORE_DAMAGED", "a row of the job database is damaged");
}

Result<std::vector<JobRow>> read_jobs(Database& database, double now) {
  std::vector<JobRow> rows;
  bool well = true;
  LB_RETURN_IF_ERROR(
      database.run("SELECT number,job FROM jobs ORDER BY number DESC", {}, [&](const Row& row) {
        v1::Job job;
        well = job.ParseFromString(row.bytes(1)) && well;
        JobRow& out = rows.emplace_back();
        out.number = row.integer(0);
        out.scene = job.scene();
        out.ended = is_terminal(job.state());
        out.age = out.ended ? now - to_seconds(job.end_time()) : 0;
        for (const v1::Artifact& artifact : job.artifacts()) out.files.push_back(artifact.digest());
      }));
  if (!well) return damaged();
  return rows;
}

/// By name; a scene is as old as the last question for its first file.
Result<std::unordered_map<std::string, SceneRow>> read_scenes(Database& database,
                                                              const BlobStore& blobs) {
  std::unordered_map<std::string, SceneRow> rows;
  bool well = true;
  LB_RETURN_IF_ERROR(database.run("SELECT number,scene FROM scenes", {}, [&](const Row& row) {
    v1::Scene scene;
    well = scene.ParseFromString(row.bytes(1)) && scene.files_size() > 0 && well;
    if (!well) return;
    SceneRow& out = rows[scene.name()];
    out.number = row.integer(0);
    out.age = blobs.idle_seconds(scene.files(0).digest().sha256());
    for (const v1::SceneFile& file : scene.files()) out.files.push_back(file.digest());
  }));
  if (!well) return damaged();
  return rows;
}

}  // namespace

Result<Collected> collect(Database& database, BlobStore& blobs, const Retention& retention) {
  Collected collected;
  Keeper keeper(retention);
  const Status forgotten = database.transaction([&]() -> Status {
    LB_ASSIGN_OR_RETURN(const auto jobs, read_jobs(database, static_cast<double>(now_us()) * 1e-6));
    LB_ASSIGN_OR_RETURN(auto scenes, read_scenes(database, blobs));
    const auto remove = [&](const char* sql, std::int64_t number, std::int64_t& count) {
      ++count;
      return database.run(sql, {number});
    };
    // First what must stay, so that it counts before what may.
    for (const JobRow& job : jobs) {
      const auto scene = scenes.find(job.scene);
      if (job.ended || scene == scenes.end()) continue;
      scene->second.needed = true;
      keeper.add(scene->second.files);
    }
    for (const JobRow& job : jobs) {
      if (!job.ended || keeper.keeps(job.age, job.files)) {
        keeper.add(job.files);
      } else {
        LB_RETURN_IF_ERROR(remove("DELETE FROM jobs WHERE number=?", job.number, collected.jobs));
      }
    }
    std::vector<SceneRow*> by_age;
    for (auto& [name, scene] : scenes) by_age.push_back(&scene);
    std::sort(by_age.begin(), by_age.end(), [](const SceneRow* a, const SceneRow* b) {
      return a->age != b->age ? a->age < b->age : a->number > b->number;
    });
    for (const SceneRow* scene : by_age) {
      if (scene->needed || keeper.keeps(scene->age, scene->files)) {
        keeper.add(scene->files);
      } else {
        LB_RETURN_IF_ERROR(
            remove("DELETE FROM scenes WHERE number=?", scene->number, collected.scenes));
      }
    }
    return {};
  });
  LB_RETURN_IF_ERROR(forgotten);
  LB_RETURN_IF_ERROR(blobs.remove_others(keeper.named(), retention.grace_seconds, collected.blobs,
                                         collected.bytes));
  return collected;
}

}  // namespace lightbatch::server
