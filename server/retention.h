#pragma once

#include <cstdint>

#include "core/base/status.h"
#include "server/blob_store.h"
#include "server/database.h"

namespace lightbatch::server {

/// How long and how much the stores keep. All zero: everything for ever.
struct Retention {
  double keep_seconds = 0;     // after a job ended, after a scene was last used; 0: no limit
  std::int64_t max_bytes = 0;  // of blobs that jobs and scenes name; oldest go first; 0: no limit
  double grace_seconds = 24 * 3600;  // whatever was used so lately stays in any case
};

struct Collected {
  std::int64_t jobs = 0;
  std::int64_t scenes = 0;
  std::int64_t blobs = 0;
  std::int64_t bytes = 0;
};

/// Forgets ended jobs and unused scenes beyond the limits, then removes the blobs that nothing
/// names any more. Jobs that have not ended, and what they need, always stay.
Result<Collected> collect(Database& database, BlobStore& blobs, const Retention& retention);

}  // namespace lightbatch::server
