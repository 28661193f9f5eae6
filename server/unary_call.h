#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/server_callback.h>

#include <utility>

#include "core/base/status.h"
#include "server/rpc_status.h"
#include "server/services.h"

namespace lightbatch::server {

/// Answers a unary call with handle() -> Result<Response>, run on the executor.
template <typename Response, typename Handle>
grpc::ServerUnaryReactor* answer(ServiceContext& context, grpc::CallbackServerContext* call,
                                 Response* response, Handle handle) {
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  ++context.metrics.active_calls;
  context.executor.post([&context, reactor, response, handle = std::move(handle)] {
    Result<Response> result = handle();
    if (result.ok()) *response = std::move(result).value();
    --context.metrics.active_calls;
    ++context.metrics.calls;
    if (!result.ok()) ++context.metrics.failed_calls;
    reactor->Finish(to_grpc(result.status()));
  });
  return reactor;
}

}  // namespace lightbatch::server
