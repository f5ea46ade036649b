// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/render_service.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <future>
#include <map>
#include <mutex>
#include <thread>

#include "protocol/base/utf8.h"
#include "server/encode/draw_annotations.h"
#include "server/encode/encode.h"
#include "server/encode/frame_encoder.h"
#include "server/encode/vector/vector_drawing.h"
#include "server/frames/encode_pool.h"
#include "server/log.h"

namespace mote::server {
namespace {

/// One session's part; the history belongs to the render thread alone, the encoder to the session's turn in
/// the pool, the target to the service's mutex.
struct Client {
    Client(RenderEvents told, PictureHistory before) : events(std::move(told)), history(std::move(before)) {}

    RenderEvents events;
    PictureHistory history;
    EncodingTarget target = {};
    FrameEncoder encoder = {};
    bool background = false;
};

/// A picture that is ready to be encoded.
struct Drawn {
    MadePicture made;
    RenderJob job;
    std::shared_ptr<Client> client;
};

/// Large ones take seconds: more than a screen shows, so that no screen waits for the next.
EncodePool::Pace paceOf(const Drawn& drawn) {
    constexpr std::size_t largest = std::size_t{3840} * 2400;
    const auto& picture = drawn.made.picture;
    const bool large = std::size_t{picture.width} * picture.height > largest;
    return large || drawn.client->background ? EncodePool::Pace::slow : EncodePool::Pace::quick;
}

PictureHistory historyOf(const RenderSettings& settings) {
    return {QualityController(settings.budgetMs)};
}

/// The picture as a document of its view's page.
Result<EncodedPicture> encodePage(const MadePicture& made, const ViewTask& task) {
    VectorDrawing drawing{
        made.picture.width, made.picture.height, glm::vec3(task.view.background), std::nullopt, {}};
    if (!made.onlyShapes) drawing.raster = made.picture;
    if (made.dots) drawing.dots = *made.dots;
    drawing.strokes = made.strokes;
    drawing.sights = made.sights;
    drawing.annotations = made.annotations;
    MOTE_ASSIGN_OR_RETURN(auto document, drawVector(drawing, *task.page));
    return EncodedPicture{proto::Frame::DOCUMENT, false, std::move(document)};
}

}  // namespace

class RenderService::Impl {
  public:
    Impl(DeviceFactory factory, StepSource& steps, RenderSettings settings)
        : factory_(std::move(factory)),
          steps_(steps),
          settings_(std::move(settings)),
          schedule_(settings_.schedule),
          encoders_(std::make_unique<EncodePool>(std::max(1u, settings_.encodeThreads))) {
        if (settings_.memory) settings_.memory->whenGivenBack([this] { dataArrived(); });
    }

    ~Impl() {
        if (settings_.memory) settings_.memory->whenGivenBack({});
        {
            const std::lock_guard lock(mutex_);
            stopping_ = true;
            for (const auto& [session, client] : clients_) schedule_.close(session);
        }
        wake_.notify_all();
        if (thread_.joinable()) thread_.join();
        encoders_.reset();
    }

    Result<std::string> start() {
        auto ready = std::make_shared<std::promise<Result<std::string>>>();
        auto name = ready->get_future();
        thread_ = std::thread([this, ready] { begin(*ready); });
        return name.get();
    }

    void open(SessionId session, std::uint32_t credits, RenderEvents events, bool background) {
        const std::lock_guard lock(mutex_);
        clients_[session] = std::make_shared<Client>(std::move(events), historyOf(settings_));
        clients_[session]->background = background;
        schedule_.open(session, credits, background);
    }

    void close(SessionId session) {
        decltype(clients_)::node_type gone;  // what it planned ends when nobody waits for the lock
        const std::lock_guard lock(mutex_);
        gone = clients_.extract(session);
        schedule_.close(session);
    }

    Status setView(SessionId session, std::shared_ptr<const ViewTask> task) {
        {
            const std::lock_guard lock(mutex_);
            MOTE_RETURN_IF_ERROR(schedule_.setView(session, std::move(task)));
        }
        wake_.notify_one();
        return success();
    }

    void setTarget(SessionId session, const EncodingTarget& target) {
        const std::lock_guard lock(mutex_);
        if (const auto found = clients_.find(session); found != clients_.end())
            found->second->target = target;
    }

    void wantKey(SessionId session) {
        const std::lock_guard lock(mutex_);
        if (const auto found = clients_.find(session); found != clients_.end())
            found->second->encoder.wantKey();
    }

    void addCredits(SessionId session, std::uint32_t count) {
        {
            const std::lock_guard lock(mutex_);
            schedule_.addCredits(session, count);
        }
        wake_.notify_one();
    }

    void dataArrived() {
        {
            const std::lock_guard lock(mutex_);
            ++arrivals_;
            schedule_.dataArrived(Clock::now());
        }
        wake_.notify_one();
    }

    std::optional<Clock::time_point> deviceFailed() const {
        const Clock::time_point at{Clock::duration(deviceFailed_)};
        return at == Clock::time_point() ? std::nullopt : std::optional(at);
    }

  private:
    void begin(std::promise<Result<std::string>>& ready) {
        try {
            auto* const crashes = settings_.crashes;
            newMaker(crashes != nullptr ? crashes->costs() : std::nullopt);
            if (crashes != nullptr) crashes->learn(maker_->costs());
        } catch (const std::exception& failure) {
            ready.set_value(Error{ErrorCode::internal, "device", failure.what()});
            return;
        }
        ready.set_value(maker_->deviceName());
        run();
        maker_.reset();  // on the thread that made it
    }

    void newMaker(std::optional<render::DeviceCosts> costs) {
        maker_.emplace(factory_, steps_, costs, render::WorkInTurns::shortTurn, settings_.memory);
    }

    void run() {
        bool tidy = false;
        std::unique_lock lock(mutex_);
        while (!stopping_) {
            auto job = schedule_.next(Clock::now());
            if (job) {
                auto client = clients_.at(job->session);
                const std::uint64_t arrivals = arrivals_;
                lock.unlock();
                serve(*std::move(job), std::move(client), arrivals);
                lock.lock();
                tidy = false;
            } else if (!tidy) {
                lock.unlock();
                maker_->trim();
                lock.lock();
                tidy = true;
            } else if (const auto due = schedule_.nextDue()) {
                wake_.wait_until(lock, *due);
            } else {
                wake_.wait(lock);
            }
        }
    }

    void serve(RenderJob job, std::shared_ptr<Client> client, std::uint64_t arrivals) {
        const auto begun = Clock::now();
        auto made = make(job, *client);
        charge(job, Clock::now() - begun);
        noteDevice(made);
        if (!made.ok()) return fail(job, *client, made.error());
        if (made->waits) return waiting(job, arrivals, made->until);
        if (!made->picture) return stopped(job);
        send(std::make_shared<Drawn>(Drawn{*std::move(made->picture), std::move(job), std::move(client)}));
    }

    /// Views that wait, or whose data is at fault, tell nothing of the device.
    void noteDevice(const Result<Making>& made) {
        if (made.ok() && made->picture) deviceFailed_ = 0;
        if (!made.ok() && made.error().where == "device") {
            deviceFailed_ = Clock::now().time_since_epoch().count();
        }
    }

    /// What is loaded for a picture that waits may still be the end of us.
    Result<Making> make(const RenderJob& job, Client& client) {
        auto* const crashes = settings_.crashes;
        if (crashes != nullptr) crashes->begin(job.task->bytes);
        auto made = makeOrRenew(job, client);
        if (crashes != nullptr && !(made.ok() && made->waits)) crashes->end();
        return made;
    }

    /// Where an invariant is broken, all that took part in the picture goes, and the next is made by others.
    Result<Making> makeOrRenew(const RenderJob& job, Client& client) {
        try {
            return maker_->make(job, client.history);
        } catch (const BrokenInvariant& broken) {
            client.history = historyOf(settings_);
            const auto costs = maker_->costs();
            maker_.reset();
            newMaker(costs);
            return Error{ErrorCode::internal, "view", broken.what()};
        }
    }

    void charge(const RenderJob& job, Clock::duration took) {
        const std::lock_guard lock(mutex_);
        schedule_.charge(job, took);
    }

    /// `arrivals`: before it was tried. What has arrived since may be what it waits for.
    void waiting(const RenderJob& job, std::uint64_t arrivals, std::optional<Clock::time_point> until) {
        const std::lock_guard lock(mutex_);
        schedule_.finishWaiting(job, until);
        if (arrivals != arrivals_) schedule_.dataArrived(Clock::now());
    }

    void stopped(const RenderJob& job) {
        const std::lock_guard lock(mutex_);
        schedule_.finishStopped(job);
    }

    void fail(const RenderJob& job, const Client& client, Error error) {
        {
            const std::lock_guard lock(mutex_);
            schedule_.finishFailed(job);
        }
        // A moving hand fails with every view: once is enough for the log.
        if (auto text = error.toString(); text != lastFailure_) {
            log::warn(log::session(job.session), "a view cannot be drawn: {}", toLogText(text));
            lastFailure_ = std::move(text);
        }
        client.events.failed(*job.task, std::move(error));
    }

    /// A refinement that nobody wants any more is not worth its way to the client.
    void send(std::shared_ptr<Drawn> drawn) {
        {
            const std::lock_guard lock(mutex_);
            if (drawn->job.stage != Stage::quick && !schedule_.current(drawn->job)) {
                return schedule_.finishStopped(drawn->job);
            }
            schedule_.finishDrawn(drawn->job, drawn->made.next);
        }
        const SessionId session = drawn->job.session;
        const auto pace = paceOf(*drawn);
        encoders_->post(
            session, [this, drawn = std::move(drawn)] { encode(*drawn); }, pace);
    }

    Result<EncodedPicture> encodedOf(Drawn& drawn) {
        try {
            if (drawn.job.task->page) return encodePage(drawn.made, *drawn.job.task);
            if (drawn.made.annotations) {
                const View& view = drawn.job.task->view;
                MOTE_RETURN_IF_ERROR(
                    drawAnnotations(*drawn.made.annotations, view.width, view.height, drawn.made.picture));
            }
            return drawn.client->encoder.encode(drawn.made.picture, drawn.job.stage == Stage::exact,
                                                targetOf(*drawn.client));
        } catch (const std::exception& failure) {
            return Error{ErrorCode::internal, "view", failure.what()};
        }
    }

    void encode(Drawn& drawn) {
        const auto begun = Clock::now();
        const auto& task = *drawn.job.task;
        auto& message = drawn.made.message;
        const auto& picture = drawn.made.picture;
        const bool exact = drawn.job.stage == Stage::exact;
        auto encoded = encodedOf(drawn);
        if (!encoded.ok()) {
            addCredits(drawn.job.session, 1);
            return drawn.client->events.failed(task, encoded.error());
        }
        message.set_encoding(encoded->encoding);
        message.set_key(encoded->key);
        message.set_format(wireFormat(picture.format));
        message.set_encode_ms(milliseconds(Clock::now() - begun));
        RenderedFrame frame{std::move(message), std::move(encoded->payload), task.arrived};
        frame.quick = drawn.job.stage == Stage::quick || task.queued;
        frame.canWait = exact;  // nothing after it needs it
        frame.wanted = task.finalOnly;
        drawn.made.picture = {};
        drawn.made.memory.become(frame.payload.size());
        frame.memory = std::move(drawn.made.memory);
        drawn.client->events.frame(std::move(frame));
    }

    EncodingTarget targetOf(const Client& client) {
        const std::lock_guard lock(mutex_);
        return client.target;
    }

    const DeviceFactory factory_;
    StepSource& steps_;
    const RenderSettings settings_;
    // The rendering thread's own.
    std::optional<PictureMaker> maker_;
    std::string lastFailure_;

    std::atomic<Clock::rep> deviceFailed_{0};  // the clock's count; 0: it draws

    std::mutex mutex_;
    std::condition_variable wake_;
    // Under the mutex.
    RenderSchedule schedule_;
    std::map<SessionId, std::shared_ptr<Client>> clients_;
    std::uint64_t arrivals_ = 0;  // of data
    bool stopping_ = false;

    std::unique_ptr<EncodePool> encoders_;
    std::thread thread_;
};

RenderService::RenderService(DeviceFactory factory, StepSource& steps, RenderSettings settings)
    : impl_(std::make_unique<Impl>(std::move(factory), steps, std::move(settings))) {}
RenderService::~RenderService() = default;

std::optional<Clock::time_point> RenderService::deviceFailed() const {
    return impl_->deviceFailed();
}
Result<std::string> RenderService::start() {
    return impl_->start();
}
void RenderService::open(SessionId session, std::uint32_t credits, RenderEvents events, bool background) {
    impl_->open(session, credits, std::move(events), background);
}
void RenderService::close(SessionId session) {
    impl_->close(session);
}
Status RenderService::setView(SessionId session, std::shared_ptr<const ViewTask> task) {
    return impl_->setView(session, std::move(task));
}
void RenderService::setTarget(SessionId session, const EncodingTarget& target) {
    impl_->setTarget(session, target);
}
void RenderService::wantKey(SessionId session) {
    impl_->wantKey(session);
}
void RenderService::addCredits(SessionId session, std::uint32_t count) {
    impl_->addCredits(session, count);
}
void RenderService::dataArrived() {
    impl_->dataArrived();
}

}  // namespace mote::server
