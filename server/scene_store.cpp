#include "server/scene_store.h"

#include <algorithm>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/hash.h"
#include "server/names.h"
#include "server/rpc_status.h"
#include "server/timestamps.h"

namespace lightbatch::server {
namespace {

constexpr std::size_t kIdDigits = 32;  // 128 bits of the manifest's SHA-256

Status not_found(const std::string& name) {
  return Status(StatusCode::kNotFound, "SCENE_NOT_FOUND", "no such scene; create it", name);
}

std::string manifest_sha256(const v1::Scene& scene) {
  Sha256 hash;
  // NUL cannot stand in a path: the text is unambiguous.
  for (const v1::SceneFile& file : scene.files()) {
    hash.update(as_bytes(file.path() + '\0' + file.digest().sha256() + '\n'));
  }
  hash.update(as_bytes(scene.main_path()));
  return hash.hex();
}

}  // namespace

Result<v1::Scene> SceneStore::create(const v1::CreateSceneRequest& request) {
  if (request.files().empty() || request.files_size() > kMaxSceneFiles) {
    return bad_request("a scene has 1 to 20,000 files", "files");
  }
  v1::Scene scene;
  scene.set_main_path(request.main_path());
  *scene.mutable_files() = request.files();
  std::sort(scene.mutable_files()->begin(), scene.mutable_files()->end(),
            [](const v1::SceneFile& a, const v1::SceneFile& b) { return a.path() < b.path(); });
  const std::string* previous = nullptr;
  bool has_main = false;
  for (const v1::SceneFile& file : scene.files()) {
    LB_RETURN_IF_ERROR(check_path(file.path()));
    LB_RETURN_IF_ERROR(check_digest(file.digest(), file.path()));
    if (previous != nullptr && *previous == file.path()) {
      return bad_request("a path stands twice in the manifest", file.path());
    }
    previous = &file.path();
    has_main = has_main || file.path() == scene.main_path();
    if (!blobs_.has(file.digest())) {
      return Status(StatusCode::kFailedPrecondition, "BLOB_MISSING",
                    "the file's bytes are not in the store; upload them first", file.path());
    }
  }
  if (!has_main) return bad_request("main_path is not one of the files", "main_path");
  scene.set_manifest_sha256(manifest_sha256(scene));
  const std::string id = scene.manifest_sha256().substr(0, kIdDigits);
  scene.set_name("scenes/" + id);
  *scene.mutable_create_time() = to_timestamp(now_us());
  LB_RETURN_IF_ERROR(
      database_.run("INSERT INTO scenes(id,scene) VALUES(?,?) ON CONFLICT DO NOTHING",
                    {id, Blob{scene.SerializeAsString()}}));
  return get(scene.name());
}

Result<v1::Scene> SceneStore::get(const std::string& name) {
  LB_ASSIGN_OR_RETURN(const std::string id, parse_name(name, "scenes/"));
  v1::Scene scene;
  bool found = false;
  LB_RETURN_IF_ERROR(
      database_.run("SELECT scene FROM scenes WHERE id=?", {id},
                    [&](const Row& row) { found = scene.ParseFromString(row.bytes(0)); }));
  if (!found) return not_found(name);
  return scene;
}

Result<v1::ListScenesResponse> SceneStore::list(const v1::ListScenesRequest& request) {
  LB_ASSIGN_OR_RETURN(const std::int64_t rows, page_rows(request.page_size()));
  LB_ASSIGN_OR_RETURN(const std::int64_t before, parse_page_token(request.page_token(), 0));
  v1::ListScenesResponse response;
  std::int64_t last = 0;
  bool more = false;
  LB_RETURN_IF_ERROR(
      database_.run("SELECT number,scene FROM scenes WHERE number<? ORDER BY number DESC LIMIT ?",
                    {before, rows + 1}, [&](const Row& row) {
                      if (response.scenes_size() == rows) {
                        more = true;
                        return;
                      }
                      last = row.integer(0);
                      v1::Scene* scene = response.add_scenes();
                      scene->ParseFromString(row.bytes(1));
                      scene->clear_files();
                    }));
  if (more) response.set_next_page_token(make_page_token(last, 0));
  return response;
}

Status SceneStore::remove(const std::string& name) {
  LB_ASSIGN_OR_RETURN(const std::string id, parse_name(name, "scenes/"));
  return database_.transaction([&]() -> Status {
    LB_RETURN_IF_ERROR(get(name).status());
    bool used = false;
    LB_RETURN_IF_ERROR(
        database_.run("SELECT 1 FROM jobs WHERE scene=? AND state IN (1,2,3) LIMIT 1", {name},
                      [&](const Row&) { used = true; }));
    if (used) {
      return Status(StatusCode::kFailedPrecondition, "SCENE_IN_USE",
                    "a job that has not ended needs this scene; cancel it first", name);
    }
    return database_.run("DELETE FROM scenes WHERE id=?", {id});
  });
}

}  // namespace lightbatch::server
