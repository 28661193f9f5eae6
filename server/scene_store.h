#pragma once

#include <string>

#include "core/base/status.h"
#include "lightbatch/v1/scene_service.pb.h"
#include "server/blob_store.h"
#include "server/database.h"

namespace lightbatch::server {

/// Scene manifests. A scene's id is the head of its manifest's SHA-256, so that the same manifest
/// is the same scene. Thread-safe.
class SceneStore {
 public:
  SceneStore(Database& database, const BlobStore& blobs) : database_(database), blobs_(blobs) {}

  /// Checks and keeps a manifest. BAD_PATH, BAD_DIGEST, BAD_REQUEST, BLOB_MISSING.
  Result<v1::Scene> create(const v1::CreateSceneRequest& request);
  /// SCENE_NOT_FOUND, BAD_REQUEST.
  Result<v1::Scene> get(const std::string& name);
  Result<v1::ListScenesResponse> list(const v1::ListScenesRequest& request);
  /// SCENE_IN_USE while a job that has not ended needs it.
  Status remove(const std::string& name);

 private:
  Database& database_;
  const BlobStore& blobs_;
};

constexpr int kMaxSceneFiles = 20'000;

}  // namespace lightbatch::server
