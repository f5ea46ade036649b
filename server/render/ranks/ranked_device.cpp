// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/ranked_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "protocol/base/most_recent.h"
#include "protocol/base/mote_check.h"
#include "server/render/blank_picture.h"
#include "server/render/cpu/composite/packet.h"
#include "server/render/cpu/cpu_device.h"
#include "server/render/cpu/flat_points.h"
#include "server/render/cpu/value_sums.h"
#include "server/render/plan/selection_cache.h"
#include "server/render/ranks/byte_stream.h"
#include "server/render/ranks/rank_frame.h"
#include "storage/storage_error.h"

namespace mote::render {
namespace {

template <class Step>
Step held(Result<Step> step) {
    if (!step.ok()) throw storage::StorageError(step.error());
    return *std::move(step);
}

/// Values by which volumes are coloured come with each order: those that were there before keep their
/// volumes.
class KnownValues {
  public:
    std::shared_ptr<const PointValues> of(const std::shared_ptr<const PointValues>& told) {
        constexpr std::size_t kept = 8;
        if (told == nullptr) return nullptr;
        const auto same = [&](const auto& known) { return known->codes == told->codes; };
        return mostRecent(values_, kept, same, [&] { return told; });
    }

  private:
    std::list<std::shared_ptr<const PointValues>> values_;  // used last first
};

/// What a rank that is not the first keeps from picture to picture.
struct KnownParts {
    SelectionCache selections = {};
    KnownValues values = {};
};

/// The volume of the points' layer, as rank 0 has it; null if there is none.
std::shared_ptr<const StepVolume> volumeOf(const PointsPlan& points, const FramePlan& plan) {
    const auto own = std::ranges::find_if(plan.fields, [&](const FieldPlan& field) {
        return field.density() != nullptr && field.layer == points.layer;
    });
    return own != plan.fields.end() ? own->density()->grid : nullptr;
}

/// How much is points of the layer that a volume is of.
const Curve& fractionOf(const FieldPlan& field, const FramePlan& plan) {
    const auto own = std::ranges::find(plan.points, field.layer, &PointsPlan::layer);
    MOTE_CHECK(own != plan.points.end());
    return own->fraction;
}

/// Gives an order's plan the rank's own data, and the same selections of them as rank 0 has.
void complete(FrameOrder& order, RankSteps& steps, KnownParts& known) {
    for (std::size_t i = 0; i < order.plan.fields.size(); ++i) {
        auto& samples = order.plan.fields[i].samples;
        if (auto* const cells = std::get_if<DensityField>(&samples)) {
            cells->step = held(steps.open(order.fieldSteps[i]));
            cells->values = known.values.of(cells->values);
            const FieldPlan& field = order.plan.fields[i];
            cells->grid = known.selections.volume(cells->step, field.transfer, fractionOf(field, order.plan),
                                                  false, cells->values);
        } else {
            std::get<CorrectedField>(samples).grid = held(steps.openGrid(order.fieldSteps[i]));
        }
    }
    for (std::size_t i = 0; i < order.plan.points.size(); ++i) {
        PointsPlan& points = order.plan.points[i];
        points.step = held(steps.open(order.pointSteps[i]));
        points.volume = volumeOf(points, order.plan);
        if (points.selection != nullptr) continue;
        points.selection = known.selections.of(points.step, points.choice());
        if (points.clips.empty()) continue;
        auto left = known.selections.cut(points.step, points.selection, points.clips, nullptr);
        points.source = std::exchange(points.step, std::move(left.step));
        points.selection = std::move(left.selection);
    }
}

/// What rank 0 says to the others; no bytes at all dismiss them. `forgotten`: pictures that are not gone on
/// with. `number`: of the picture that is begun or gone on with; 0: none. `order`: of one that is begun.
Bytes pack(const std::vector<std::uint64_t>& forgotten, std::uint64_t number, const Bytes& order) {
    ByteWriter out;
    out.putList(forgotten);
    out.put(number);
    out.putList(order);
    return out.take();
}

/// Pictures that gave way and then went, from any thread: the others hear of them with the next message.
class ForgottenPictures {
  public:
    void add(std::uint64_t picture) {
        const std::lock_guard lock(mutex_);
        numbers_.push_back(picture);
    }
    /// All that the others have not heard of; they hear of them now.
    std::vector<std::uint64_t> take() {
        const std::lock_guard lock(mutex_);
        return std::exchange(numbers_, {});
    }
    bool any() {
        const std::lock_guard lock(mutex_);
        return !numbers_.empty();
    }

  private:
    std::mutex mutex_;
    std::vector<std::uint64_t> numbers_;
};

/// The pictures of a rank that is not the first.
class ServedPictures {
  public:
    ServedPictures(Ranks& ranks, RankSteps& steps, unsigned threads)
        : ranks_(ranks), steps_(steps), parts_(threads) {
        parts_.fields.countTo(steps.budget());
    }

    /// `message`: as pack() made it.
    void serve(const Bytes& message) {
        ByteReader in(message);
        for (auto count = in.get<std::uint64_t>(); count > 0; --count)
            pictures_.erase(in.get<std::uint64_t>());
        parts_.dropExpired();
        const auto number = in.get<std::uint64_t>();
        const auto order = in.getSpan();
        if (!order.empty()) return begin(number, order);
        if (number == 0) return;
        const auto found = pictures_.find(number);
        MOTE_CHECK(found != pictures_.end());
        if (!found->second->advance({})) return;
        found->second->giveBack();
        pictures_.erase(found);
    }
    /// A stop that came too late is not left behind.
    void end() { ranks_.stopArrived(latest_); }

  private:
    void begin(std::uint64_t number, std::span<const std::byte> order) {
        latest_ = number;
        // A device that was made anew counts from the first one again.
        pictures_.erase(pictures_.lower_bound(number), pictures_.end());
        Agreement before(ranks_);
        before.attempt([&] {
            pictures_.emplace(number, std::make_unique<SharedPicture>(ranks_, parts_, unpackOrder(order)));
        });
        const auto made = pictures_.find(number);
        if (made == pictures_.end()) {
            before.all({});  // the others hear of it where they first agree
            return;
        }
        SharedPicture& picture = *made->second;
        picture.agreement().attempt([&] {
            steps_.beginPicture();
            parts_.arena.execute([&] { complete(picture.order(), steps_, known_); });
        });
        if (!picture.begin({}) || picture.drawn()) pictures_.erase(made);
    }

    Ranks& ranks_;
    RankSteps& steps_;
    CpuParts parts_;
    KnownParts known_;
    std::uint64_t latest_ = 0;
    std::map<std::uint64_t, std::unique_ptr<SharedPicture>> pictures_;  // that gave way, by number
};

}  // namespace

struct RankedDevice::State {
    FrameOrder orderOf(const FramePlan& plan, PixelFormat format);
    template <class Step>
    RankSteps::Name nameOf(const Step& step) {
        auto name = steps.nameOf(step);
        if (!name.ok()) throw storage::StorageError(name.error());
        return *std::move(name);
    }

    Ranks& ranks;
    RankSteps& steps;
    CpuParts parts;
    std::uint64_t pictures = 0;
    std::shared_ptr<ForgottenPictures> forgotten = std::make_shared<ForgottenPictures>();

    /// `order`: of a picture that is begun; as large as its colours of pixels.
    void say(std::uint64_t number, const Bytes& order = {}) {
        auto bytes = pack(forgotten->take(), number, order);
        ranks.broadcast(bytes);
    }
};

/// A picture between two batches of its tiles.
class RankedDevice::Unfinished final : public UnfinishedPicture {
  public:
    Unfinished(State& state, FrameOrder order)
        : state_(state), forgotten_(state.forgotten), shared_(state.ranks, state.parts, std::move(order)) {}
    ~Unfinished() override {
        if (waits_) forgotten_->add(shared_.number());
    }

    /// As Device::begin.
    bool begin(const std::stop_token& stop) {
        state_.say(shared_.number(), packOrder(shared_.order()));
        waits_ = true;
        const bool begun = shared_.begin(stop);
        waits_ = begun && !shared_.drawn();
        throwFailure();
        return begun;
    }
    bool advance(const std::stop_token& pause) override {
        if (!waits_) return true;
        state_.say(shared_.number());
        waits_ = !shared_.advance(pause);
        throwFailure();
        return !waits_;
    }
    Picture take() override { return shared_.take(); }
    std::uint64_t bytes() const override { return shared_.bytes(); }

  private:
    void throwFailure() {
        if (const auto& failure = shared_.agreement().failure()) throw storage::StorageError(*failure);
    }

    State& state_;
    const std::shared_ptr<ForgottenPictures> forgotten_;
    SharedPicture shared_;
    bool waits_ = false;  // the others may keep their parts of it
};

FrameOrder RankedDevice::State::orderOf(const FramePlan& plan, PixelFormat format) {
    FrameOrder order{.number = ++pictures,
                     .format = format,
                     .flatPoints = {},
                     .pointSteps = {},
                     .fieldSteps = {},
                     .plan = plan,
                     .colors = {}};
    // Other ranks have no surfaces.
    for (const auto& surface : std::exchange(order.plan.surfaces, {})) {
        auto fragments = parts.arena.execute([&] { return allOf(*surface, plan.width, plan.height); });
        if (!fragments.empty())
            order.plan.fragments.push_back(std::make_shared<const Fragments>(std::move(fragments)));
    }
    for (const auto& points : plan.points)
        order.pointSteps.push_back(nameOf(points.clips.empty() ? *points.step : *points.source));
    for (const auto& field : plan.fields) {
        if (const auto* const cells = field.density()) {
            order.fieldSteps.push_back(nameOf(*cells->step));
            continue;
        }
        const CorrectedField& samples = *field.grid();
        order.fieldSteps.push_back(nameOf(*samples.grid));
        // What the field has of what the plan asks for: the rest may be on its way.
        if (samples.corrected()) order.fieldSteps.back().parts = samples.grid->parts;
    }
    order.flatPoints = flatPoints(plan, parts.arena.execute([&] { return parts.fields.of(plan); }));
    return order;
}

RankedDevice::RankedDevice(Ranks& ranks, RankSteps& steps, unsigned threads)
    : state_(new State{ranks, steps, CpuParts(threads)}) {}

RankedDevice::~RankedDevice() = default;

std::string RankedDevice::name() const {
    return fmt::format("{} on {} ranks", cpuName(state_->parts.arena.max_concurrency()),
                       state_->ranks.size());
}

DeviceCosts RankedDevice::costs() {
    // Those of this rank alone, shared out: what the exchange adds, the pictures tell.
    auto costs = CpuDevice({static_cast<unsigned>(state_->parts.arena.max_concurrency())}).costs();
    costs.millionPoints /= state_->ranks.size();
    costs.millionPixels /= state_->ranks.size();
    return costs;
}

DeviceAbilities RankedDevice::abilities() const {
    return {.allPoints = false};
}

std::optional<Picture> RankedDevice::render(const FramePlan& plan, PixelFormat format, std::stop_token stop) {
    const auto picture = begin(plan, format, stop);
    if (picture == nullptr || !picture->advance(stop)) return std::nullopt;
    return picture->take();
}

std::unique_ptr<UnfinishedPicture> RankedDevice::begin(const FramePlan& plan, PixelFormat format,
                                                       std::stop_token stop) {
    MOTE_CHECK(plan.width > 0 && plan.height > 0 && plan.fields.size() <= Packet::mostFields);
    MOTE_CHECK(plan.slabs <= mostSlabs);
    if (stop.stop_requested()) return nullptr;
    if (plan.blank()) return finishedPicture(blankPicture(plan, format));
    FrameOrder order = state_->orderOf(plan, format);
    // Rank 0 alone has the values of columns: it reads the points that they colour.
    const ColorSearch search{.count = false, .cellsAreShaded = !order.flatPoints};
    auto colors =
        state_->parts.arena.execute([&] { return frameColors(plan, state_->parts.leaves, stop, search); });
    if (!colors) return nullptr;
    order.colors = *std::move(colors);
    auto picture = std::make_unique<Unfinished>(*state_, std::move(order));
    return picture->begin(stop) ? std::move(picture) : nullptr;
}

void RankedDevice::countTo(const std::shared_ptr<storage::BlockBudget>& budget) {
    state_->parts.fields.countTo(budget);
}

void RankedDevice::trim() {
    state_->parts.dropExpired();
    if (state_->forgotten->any()) state_->say(0);
}

void dismissRanks(Ranks& ranks) {
    Bytes nothing;
    ranks.broadcast(nothing);
}

void serveRanks(Ranks& ranks, RankSteps& steps, unsigned threads) noexcept {
    ServedPictures pictures(ranks, steps, threads);
    for (Bytes bytes;;) {
        ranks.broadcast(bytes);
        if (bytes.empty()) break;
        pictures.serve(bytes);
    }
    pictures.end();
}

}  // namespace mote::render
