#pragma once

#include <grpcpp/support/status.h>

#include <map>
#include <string>

#include "core/base/status.h"

namespace lightbatch::server {

/// What is wrong with a request, and in which of its fields or files: BAD_REQUEST.
Status bad_request(std::string message, std::string place);

/// A Status as gRPC sends it: code and message, and in the details an RpcStatus with one
/// ErrorDetail (reason, place, metadata).
grpc::Status to_grpc(const Status& status, const std::map<std::string, std::string>& metadata = {});

}  // namespace lightbatch::server
