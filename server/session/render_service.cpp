// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/render_service.h"

#include <spdlog/spdlog.h>

#include <condition_variable>
#include <future>
#include <map>
#include <mutex>
#include <thread>

#include "server/encode/encode.h"
#include "server/render/frame_plan.h"
#include "server/session/encode_pool.h"
#include "server/session/quality_controller.h"
#include "server/session/utf8.h"
#include "storage/storage_error.h"

namespace mote::server {
namespace {

// A device that fails twice in a row (a driver was reset, its memory is lost) is made anew.
constexpr int failuresBeforeNewDevice = 2;

/// What rendering knows of one session; all but the events belongs to the render thread.
struct Client {
    RenderEvents events;
    QualityController quality;
    std::vector<std::shared_ptr<const storage::ParticleStep>> steps = {};  // of the latest picture
    double exactPoints = 0.0;  // that its exact picture would have drawn
};

/// A picture that is ready to be encoded.
struct Drawn {
    render::Picture picture;
    proto::Frame message;
    RenderJob job;
    std::shared_ptr<Client> client;
};

Error describe(const std::exception& failure) {
    if (const auto* storage = dynamic_cast<const storage::StorageError*>(&failure)) return storage->error();
    if (dynamic_cast<const std::bad_alloc*>(&failure)) {
        return {ErrorCode::resourceExhausted, "view", "there is not enough memory to draw it"};
    }
    return {ErrorCode::internal, "device", failure.what()};
}

/// A field gets its place in the view, a file keeps its own.
Error inLayer(std::size_t index, const Error& error) {
    const bool field = error.where.find('/') == std::string::npos;
    return field ? error.within("layers[" + std::to_string(index) + "]") : error;
}

/// How many points an exact picture draws depends on the view, and the latest picture of the same data tells
/// it best: views of one hand follow each other closely. It is taken with care (a view that saw nothing is
/// followed by one that does), and of new data all points are expected.
ViewLoad loadOf(const render::Scene& scene, const Client& client) {
    ViewLoad load{static_cast<double>(scene.view.width) * scene.view.height, 0.0};
    for (const auto& step : scene.steps) load.points += static_cast<double>(step->pointCount());
    if (scene.steps == client.steps) load.points = std::max(client.exactPoints, 0.01 * load.points);
    return load;
}

void learn(Client& client, const render::Scene& scene, const render::Picture& picture,
           const render::Quality& quality, double ms) {
    const auto points = static_cast<double>(picture.pointsDrawn);
    client.quality.learn(static_cast<double>(picture.width) * picture.height, points, quality, ms);
    client.steps = scene.steps;
    client.exactPoints = points / quality.pointFraction;
}

}  // namespace

class RenderService::Impl {
  public:
    Impl(DeviceFactory factory, StepSource& steps, RenderSettings settings)
        : factory_(std::move(factory)),
          steps_(steps),
          settings_(settings),
          schedule_(settings.schedule),
          encoders_(std::make_unique<EncodePool>(std::max(1u, settings.encodeThreads))) {}

    ~Impl() {
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

    void open(SessionId session, std::uint32_t credits, RenderEvents events) {
        const std::lock_guard lock(mutex_);
        clients_[session] =
            std::make_shared<Client>(Client{std::move(events), QualityController(settings_.budgetMs)});
        schedule_.open(session, credits);
    }

    void close(SessionId session) {
        const std::lock_guard lock(mutex_);
        clients_.erase(session);
        schedule_.close(session);
    }

    void setView(SessionId session, std::shared_ptr<const ViewTask> task) {
        {
            const std::lock_guard lock(mutex_);
            schedule_.setView(session, std::move(task));
        }
        wake_.notify_one();
    }

    void addCredits(SessionId session, std::uint32_t count) {
        {
            const std::lock_guard lock(mutex_);
            schedule_.addCredits(session, count);
        }
        wake_.notify_one();
    }

  private:
    void begin(std::promise<Result<std::string>>& ready) {
        try {
            device_ = factory_();
            deviceName_ = device_->name();
        } catch (const std::exception& failure) {
            ready.set_value(Error{ErrorCode::internal, "device", failure.what()});
            return;
        }
        ready.set_value(deviceName_);
        run();
        device_.reset();
    }

    void run() {
        bool tidy = false;
        std::unique_lock lock(mutex_);
        while (!stopping_) {
            auto job = schedule_.next(Clock::now());
            if (job) {
                auto client = clients_.at(job->session);
                lock.unlock();
                serve(*std::move(job), std::move(client));
                lock.lock();
                tidy = false;
            } else if (!tidy) {
                lock.unlock();
                if (device_) device_->trim();
                lock.lock();
                tidy = true;
            } else if (const auto due = schedule_.nextDue()) {
                wake_.wait_until(lock, *due);
            } else {
                wake_.wait(lock);
            }
        }
    }

    void serve(RenderJob job, std::shared_ptr<Client> client) {
        auto drawn = tryDraw(job, *client);
        if (!drawn.ok()) return fail(job, *client, drawn.error());
        if (!*drawn) return finishStopped(job);
        (*drawn)->job = std::move(job);
        (*drawn)->client = std::move(client);
        send(*std::move(*drawn));
    }

    Result<std::optional<Drawn>> tryDraw(const RenderJob& job, Client& client) {
        try {
            auto drawn = draw(job, client);
            failures_ = 0;
            return drawn;
        } catch (const render::DeviceError& failure) {
            renewDevice();
            return describe(failure);
        } catch (const std::exception& failure) {
            return describe(failure);
        }
    }

    /// A device is only given up after it failed again: one picture may simply be too large for it.
    void renewDevice() {
        if (++failures_ < failuresBeforeNewDevice) return;
        spdlog::warn("the device failed {} times in a row and is made anew", failures_);
        failures_ = 0;
        device_.reset();
    }

    /// Empty: it was stopped.
    Result<std::optional<Drawn>> draw(const RenderJob& job, Client& client) {
        const auto begun = Clock::now();
        if (!device_) device_ = factory_();
        auto scene = makeScene(job.task->view);
        if (!scene.ok()) return scene.error();
        const auto quality = qualityOf(job, client, loadOf(*scene, client));
        const auto plan = render::makeFramePlan(*scene, quality);
        const auto planned = Clock::now();
        const auto format = job.stage == Stage::exact ? job.task->format : render::PixelFormat::srgb8;
        auto picture = device_->render(plan, format, job.stop);
        if (!picture) return std::optional<Drawn>();
        const auto rendered = Clock::now();
        learn(client, *scene, *picture, quality, milliseconds(rendered - planned));
        Drawn drawn{*std::move(picture), {}, {}, {}};
        auto& message = drawn.message;
        message.set_view_id(job.task->viewId);
        message.set_asked_ns(job.task->askedNs);
        message.set_final(job.stage == Stage::exact);
        message.set_point_fraction(quality.pointFraction);
        message.set_queued_ms(milliseconds(begun - job.task->arrived));
        message.set_plan_ms(milliseconds(planned - begun));
        message.set_render_ms(milliseconds(rendered - planned));
        message.set_points_drawn(drawn.picture.pointsDrawn);
        message.set_device(deviceName_);
        return std::optional<Drawn>(std::move(drawn));
    }

    Result<render::Scene> makeScene(const View& view) {
        render::Scene scene{view, {}};
        for (std::size_t i = 0; i < view.layers.size(); ++i) {
            auto step = steps_.step(view.layers[i].dataset, view.layers[i].step);
            if (!step.ok()) return inLayer(i, step.error());
            scene.steps.push_back(*std::move(step));
        }
        return scene;
    }

    static render::Quality qualityOf(const RenderJob& job, Client& client, const ViewLoad& load) {
        switch (job.stage) {
            case Stage::quick:
                return client.quality.quick(load);
            case Stage::intermediate:
                return client.quality.intermediate(load);
            default:
                return render::Quality::exact();
        }
    }

    Stage stageAfter(const Drawn& drawn) const {
        if (drawn.job.stage == Stage::exact) return Stage::done;
        if (drawn.job.stage == Stage::intermediate) return Stage::exact;
        const auto& view = drawn.job.task->view;
        const ViewLoad load{static_cast<double>(view.width) * view.height, drawn.client->exactPoints};
        return drawn.client->quality.worthIntermediate(load) ? Stage::intermediate : Stage::exact;
    }

    /// A refinement that nobody wants any more is not worth its way to the client.
    void send(Drawn drawn) {
        const Stage next = stageAfter(drawn);
        {
            const std::lock_guard lock(mutex_);
            if (drawn.job.stage != Stage::quick && !schedule_.current(drawn.job)) {
                return schedule_.finishStopped(drawn.job);
            }
            schedule_.finishDrawn(drawn.job, next);
        }
        const SessionId session = drawn.job.session;
        auto shared = std::make_shared<Drawn>(std::move(drawn));
        encoders_->post(session, [this, shared] { encode(*shared); });
    }

    void encode(Drawn& drawn) {
        const auto begun = Clock::now();
        const bool exact = drawn.job.stage == Stage::exact;
        auto payload = exact ? encodeLossless(drawn.picture) : encodeJpeg(drawn.picture);
        if (!payload.ok()) {
            addCredits(drawn.job.session, 1);
            return drawn.client->events.failed(drawn.job.task->request, payload.error());
        }
        auto& message = drawn.message;
        message.set_width(drawn.picture.width);
        message.set_height(drawn.picture.height);
        message.set_encoding(exact ? proto::Frame::ZSTD : proto::Frame::JPEG);
        message.set_format(wireFormat(drawn.picture.format));
        message.set_encode_ms(milliseconds(Clock::now() - begun));
        drawn.client->events.frame({std::move(message), *std::move(payload), drawn.job.task->arrived});
    }

    void finishStopped(const RenderJob& job) {
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
            spdlog::warn("a view cannot be drawn: {}", toLogText(text));
            lastFailure_ = std::move(text);
        }
        client.events.failed(job.task->request, std::move(error));
    }

    const DeviceFactory factory_;
    StepSource& steps_;
    const RenderSettings settings_;
    // Of the render thread.
    std::unique_ptr<render::Device> device_;
    std::string deviceName_;
    int failures_ = 0;  // of the device, in a row
    std::string lastFailure_;

    std::mutex mutex_;
    std::condition_variable wake_;
    // Under the mutex.
    RenderSchedule schedule_;
    std::map<SessionId, std::shared_ptr<Client>> clients_;
    bool stopping_ = false;

    std::unique_ptr<EncodePool> encoders_;
    std::thread thread_;
};

RenderService::RenderService(DeviceFactory factory, StepSource& steps, RenderSettings settings)
    : impl_(std::make_unique<Impl>(std::move(factory), steps, settings)) {}
RenderService::~RenderService() = default;

Result<std::string> RenderService::start() {
    return impl_->start();
}
void RenderService::open(SessionId session, std::uint32_t credits, RenderEvents events) {
    impl_->open(session, credits, std::move(events));
}
void RenderService::close(SessionId session) {
    impl_->close(session);
}
void RenderService::setView(SessionId session, std::shared_ptr<const ViewTask> task) {
    impl_->setView(session, std::move(task));
}
void RenderService::addCredits(SessionId session, std::uint32_t count) {
    impl_->addCredits(session, count);
}

}  // namespace mote::server
