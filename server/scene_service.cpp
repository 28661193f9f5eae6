#include "lightbatch/v1/scene_service.grpc.pb.h"
#include "server/services.h"
#include "server/unary_call.h"

namespace lightbatch::server {
namespace {

class SceneService final : public v1::SceneService::CallbackService {
 public:
  explicit SceneService(ServiceContext& context) : context_(context) {}

  grpc::ServerUnaryReactor* CreateScene(grpc::CallbackServerContext* call,
                                        const v1::CreateSceneRequest* request,
                                        v1::Scene* response) override {
    return answer(context_, call, response,
                  [this, request] { return context_.scenes.create(*request); });
  }
  grpc::ServerUnaryReactor* GetScene(grpc::CallbackServerContext* call,
                                     const v1::GetSceneRequest* request,
                                     v1::Scene* response) override {
    return answer(context_, call, response,
                  [this, request] { return context_.scenes.get(request->name()); });
  }
  grpc::ServerUnaryReactor* ListScenes(grpc::CallbackServerContext* call,
                                       const v1::ListScenesRequest* request,
                                       v1::ListScenesResponse* response) override {
    return answer(context_, call, response,
                  [this, request] { return context_.scenes.list(*request); });
  }
  grpc::ServerUnaryReactor* DeleteScene(grpc::CallbackServerContext* call,
                                        const v1::DeleteSceneRequest* request,
                                        v1::DeleteSceneResponse* response) override {
    return answer(context_, call, response, [this, request]() -> Result<v1::DeleteSceneResponse> {
      LB_RETURN_IF_ERROR(context_.scenes.remove(request->name()));
      return v1::DeleteSceneResponse();
    });
  }

 private:
  ServiceContext& context_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_scene_service(ServiceContext& context) {
  return std::make_unique<SceneService>(context);
}

}  // namespace lightbatch::server
