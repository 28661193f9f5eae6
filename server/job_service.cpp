#include <mutex>

#include "lightbatch/v1/job_service.grpc.pb.h"
#include "server/services.h"
#include "server/submission.h"
#include "server/unary_call.h"

namespace lightbatch::server {
namespace {

Result<v1::Job> submit(ServiceContext& context, const v1::SubmitJobRequest& request) {
  LB_ASSIGN_OR_RETURN(const v1::Scene scene, context.scenes.get(request.scene()));
  LB_ASSIGN_OR_RETURN(
      JobStore::Submission submission,
      make_submission(request, scene, context.engine, context.limits.max_job_seconds));
  LB_ASSIGN_OR_RETURN(
      v1::Job job,
      context.board.submit(std::move(submission), request.cache_policy() != v1::CACHE_POLICY_OFF));
  if (job.cache_hit()) ++context.metrics.cache_hits;
  return job;
}

/// Sends snapshots of one job whenever its sequence moved past the cursor. While a write is under
/// way changes only mark the watcher stale: a slow reader skips progress, never the last state.
class WatchReactor final : public grpc::ServerWriteReactor<v1::JobEvent> {
 public:
  WatchReactor(ServiceContext& context, const v1::WatchJobRequest& request)
      : context_(context),
        name_(request.name()),
        cursor_(request.after_sequence()),
        active_(context.metrics.active_calls),
        active_watcher_(context.metrics.active_watchers) {}

  /// Posted work holds `self`, so that a change cannot meet a deleted watcher.
  static grpc::ServerWriteReactor<v1::JobEvent>* start(std::shared_ptr<WatchReactor> self) {
    WatchReactor* reactor = self.get();
    reactor->self_ = self;
    const std::weak_ptr<WatchReactor> weak = self;
    reactor->token_ = reactor->context_.board.watch(reactor->name_, [weak, reactor] {
      if (auto alive = weak.lock()) {
        reactor->context_.executor.post([alive = std::move(alive)] { alive->pump(); });
      }
    });
    reactor->context_.executor.post([self = std::move(self)] { self->pump(); });
    return reactor;
  }

  void OnWriteDone(bool ok) override {
    {
      const std::lock_guard lock(mutex_);
      writing_ = false;
      broken_ = broken_ || !ok;
    }
    context_.executor.post([self = self_] { self->pump(); });
  }
  void OnCancel() override {
    {
      const std::lock_guard lock(mutex_);
      broken_ = true;
    }
    context_.executor.post([self = self_] { self->pump(); });
  }
  void OnDone() override {
    context_.board.unwatch(name_, token_);
    const std::shared_ptr<WatchReactor> last = std::move(self_);
  }

 private:
  void pump() {
    const std::lock_guard lock(mutex_);
    if (writing_ || finished_) return;
    if (broken_) return finish(cancelled());
    if (context_.metrics.active_watchers > context_.limits.max_watchers) {
      return finish(Status(StatusCode::kResourceExhausted, "QUOTA_EXCEEDED",
                           "too many watchers; poll GetJob instead"));
    }
    auto job = context_.board.get(name_);
    if (!job.ok()) return finish(job.status());
    if (job->sequence() > cursor_) {
      cursor_ = job->sequence();
      event_.set_sequence(cursor_);
      *event_.mutable_job() = std::move(job).value();
      writing_ = true;
      StartWrite(&event_);
    } else if (is_terminal(job->state())) {
      finish({});
    } else if (context_.board.stopping()) {
      finish(Status(StatusCode::kUnavailable, "DRAINING",
                    "the server is going away; watch again with the last sequence"));
    }
  }

  void finish(const Status& status) {
    finished_ = true;
    ++context_.metrics.calls;
    if (!status.ok()) ++context_.metrics.failed_calls;
    Finish(to_grpc(status));
  }

  ServiceContext& context_;
  const std::string name_;
  std::shared_ptr<WatchReactor> self_;
  std::uint64_t token_ = 0;
  std::mutex mutex_;
  std::int64_t cursor_;
  const Active active_;
  const Active active_watcher_;
  v1::JobEvent event_;
  bool writing_ = false;
  bool broken_ = false;
  bool finished_ = false;
};

class JobService final : public v1::JobService::CallbackService {
 public:
  explicit JobService(ServiceContext& context) : context_(context) {}

  grpc::ServerUnaryReactor* SubmitJob(grpc::CallbackServerContext* call,
                                      const v1::SubmitJobRequest* request,
                                      v1::Job* response) override {
    return answer(context_, call, response, [this, request] { return submit(context_, *request); });
  }
  grpc::ServerUnaryReactor* GetJob(grpc::CallbackServerContext* call,
                                   const v1::GetJobRequest* request, v1::Job* response) override {
    return answer(context_, call, response,
                  [this, request] { return context_.board.get(request->name()); });
  }
  grpc::ServerUnaryReactor* ListJobs(grpc::CallbackServerContext* call,
                                     const v1::ListJobsRequest* request,
                                     v1::ListJobsResponse* response) override {
    return answer(context_, call, response,
                  [this, request] { return context_.board.list(*request); });
  }
  grpc::ServerWriteReactor<v1::JobEvent>* WatchJob(grpc::CallbackServerContext*,
                                                   const v1::WatchJobRequest* request) override {
    return WatchReactor::start(std::make_shared<WatchReactor>(context_, *request));
  }
  grpc::ServerUnaryReactor* CancelJob(grpc::CallbackServerContext* call,
                                      const v1::CancelJobRequest* request,
                                      v1::Job* response) override {
    return answer(context_, call, response,
                  [this, request] { return context_.board.cancel(request->name()); });
  }

 private:
  ServiceContext& context_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_job_service(ServiceContext& context) {
  return std::make_unique<JobService>(context);
}

}  // namespace lightbatch::server
