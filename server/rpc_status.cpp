#include "server/rpc_status.h"

#include <utility>

#include "lightbatch/v1/types.pb.h"

namespace lightbatch::server {

Status bad_request(std::string message, std::string place) {
  return Status(StatusCode::kInvalidArgument, "BAD_REQUEST", std::move(message), std::move(place));
}

grpc::Status to_grpc(const Status& status, const std::map<std::string, std::string>& metadata) {
  if (status.ok()) return grpc::Status::OK;
  v1::ErrorDetail detail;
  detail.set_reason(status.reason());
  detail.set_place(status.place());
  for (const auto& [key, value] : metadata) (*detail.mutable_metadata())[key] = value;
  v1::RpcStatus rich;
  rich.set_code(static_cast<int>(status.code()));
  rich.set_message(status.message());
  rich.add_details()->PackFrom(detail);
  return grpc::Status(static_cast<grpc::StatusCode>(status.code()), status.message(),
                      rich.SerializeAsString());
}

}  // namespace lightbatch::server
