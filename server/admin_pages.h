#pragma once

#include <atomic>
#include <string_view>

#include "server/admin_http.h"
#include "server/services.h"

namespace lightbatch::server {

/// The pages of the admin port: /healthz (the process lives), /readyz (it takes work), /metrics
/// (Prometheus text), /jobs (HTML), /jobs/{id}/report and /jobs/{id}/{artifact} (a job's files).
AdminAnswer admin_page(ServiceContext& context, Database& database, std::string_view path);

}  // namespace lightbatch::server
