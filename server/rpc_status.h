#pragma once

#include <grpcpp/support/status.h>

#include <map>
#include <string>

#include "core/base/status.h"

namespace lightbatch::server {

/// A Status as gRPC sends it: code and message, and in the details an RpcStatus with one
/// ErrorDetail (reason, place, metadata).
grpc::Status to_grpc(const Status& status, const std::map<std::string, std::string>& metadata = {});

}  // namespace lightbatch::server
