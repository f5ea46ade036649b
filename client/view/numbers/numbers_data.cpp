// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/numbers_data.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace mote::client {
Result<std::optional<PickedPoint>> pickedOf(const QueryAnswer& answer, const proto::PickQuery& asked) {
    if (!answer.message.has_picked())
        return corrupt("answer.picked", "the server answered with something else");
    const auto& message = answer.message.picked();
    if (!message.found()) return std::optional<PickedPoint>();
    if (message.layer() >= static_cast<std::uint32_t>(asked.view().layers_size()))
        return corrupt("answer.picked", "the server picked a point of a layer that there is not");
    const bool place = message.position_size() == 3 &&
                       std::ranges::all_of(message.position(), [](double x) { return std::isfinite(x); });
    if (!place || !std::isfinite(message.distance()))
        return corrupt("answer.picked", "the server's point has no place");
    const int count = message.names_size();
    if (message.units_size() != count || message.values_size() != count)
        return corrupt("answer.picked", "the server's values do not belong to their names");
    PickedPoint picked;
    picked.step = answer.message.step();
    picked.layer = message.layer();
    picked.point = message.point();
    picked.row = message.row();
    picked.distance = message.distance();
    picked.position = {message.position(0), message.position(1), message.position(2)};
    picked.density = message.density();
    for (int i = 0; i < count; ++i)
        picked.values.push_back({message.names(i), message.units(i), message.values(i)});
    if (message.has_id()) picked.id = message.id();
    return std::optional(std::move(picked));
}

bool LatestQuery::want(const proto::Query& query, QueryLine::Reply reply) {
    auto bytes = query.SerializeAsString();
    if (bytes == asked_) return false;
    drop();
    asked_ = std::move(bytes);
    const auto mine = ++questions_;
    asking_ = mine;
    const auto request = line_.ask(query, [this, mine, reply = std::move(reply)](Result<QueryAnswer> answer) {
        if (asking_ == mine) hear(answer, reply);
    });
    if (asking_ == mine) request_ = request;
    return true;
}

void LatestQuery::hear(const Result<QueryAnswer>& answer, const QueryLine::Reply& reply) {
    if (!answer.ok() || answer->message.last()) {
        asking_ = 0;
        request_.reset();
    }
    reply(answer);
}

void LatestQuery::drop() {
    asked_.clear();
    asking_ = 0;
    if (request_) line_.cancel(*std::exchange(request_, std::nullopt));
}

namespace {

/// A server that names more steps than this is not believed.
constexpr std::uint32_t mostSteps = 1U << 20;

proto::Query queryOf(const NumbersWanted& wanted, bool selected) {
    proto::Query query;
    query.set_dataset(wanted.dataset);
    query.set_steps(fmt::format("{0}:{0}:1", wanted.step));
    if (selected && wanted.selection) *query.mutable_select() = *wanted.selection;
    return query;
}

template <class T>
void take(Result<T> result, NumbersData::Known<T>& known) {
    known.failure = result.ok() ? std::string() : result.error().toString();
    if (result.ok()) {
        known.value = *std::move(result);
    } else {
        known.value.reset();
    }
}

}  // namespace

NumbersData::NumbersData(const QueryLine& line)
    : wholeQuery_(line), selectedQuery_(line), seriesQuery_(line), histogramQuery_(line), pickQuery_(line) {}

void NumbersData::want(const NumbersWanted& wanted) {
    if (wanted.dataset != dataset_) forget();
    dataset_ = wanted.dataset;
    wantWhole(wanted);
    wantSelected(wanted);
    wantHistogram(wanted);
    if (!wanted.moving) wantSeries(wanted);
}

void NumbersData::wantWhole(const NumbersWanted& wanted) {
    if (!wanted.whole) {
        wholeQuery_.drop();
        whole_ = {};
        return;
    }
    auto query = queryOf(wanted, false);
    query.mutable_statistics();
    wholeQuery_.want(query, [this](const Result<QueryAnswer>& answer) {
        take(answer.ok() ? statisticsOf(*answer) : answer.error(), whole_);
    });
}

void NumbersData::wantSelected(const NumbersWanted& wanted) {
    if (!wanted.selection) {
        selectedQuery_.drop();
        selected_ = {};
        return;
    }
    auto query = queryOf(wanted, true);
    query.mutable_statistics();
    selectedQuery_.want(query, [this](const Result<QueryAnswer>& answer) {
        take(answer.ok() ? statisticsOf(*answer) : answer.error(), selected_);
    });
}

void NumbersData::wantSeries(const NumbersWanted& wanted) {
    if (!wanted.selection || wanted.series.empty()) {
        seriesQuery_.drop();
        series_ = {};
        return;
    }
    auto query = queryOf(wanted, true);
    query.clear_steps();  // all of them
    query.mutable_statistics()->add_names(wanted.series);
    const bool asked = seriesQuery_.want(query, [this](const Result<QueryAnswer>& answer) {
        const auto statistics = answer.ok() ? statisticsOf(*answer) : answer.error();
        if (!statistics.ok()) {
            series_.failure = statistics.error().toString();
            return;
        }
        if (statistics->values.size() != 1 || statistics->step >= mostSteps) return;
        auto& values = *series_.value;
        const std::size_t least = statistics->step + std::size_t{1};
        if (values.size() < least) values.resize(least, std::numeric_limits<double>::quiet_NaN());
        values[statistics->step] = statistics->values.front();
    });
    if (asked) series_ = {std::vector<double>(), {}, false};
}

void NumbersData::wantHistogram(const NumbersWanted& wanted) {
    if (!wanted.histogram) {
        histogramQuery_.drop();
        histogram_ = {};
        return;
    }
    auto query = queryOf(wanted, wanted.histogramOfSelection);
    *query.mutable_histogram() = *wanted.histogram;
    histogramQuery_.want(query, [this, asked = *wanted.histogram](const Result<QueryAnswer>& answer) {
        take(answer.ok() ? histogramOf(*answer, asked) : answer.error(), histogram_);
    });
}

void NumbersData::pick(const proto::PickQuery& place) {
    proto::Query query;
    const auto& layer = place.view().layers(0);
    query.set_dataset(layer.dataset());
    query.set_steps(fmt::format("{0}:{0}:1", layer.step()));
    *query.mutable_pick() = place;
    pickQuery_.drop();  // the same place again may be another point
    pickQuery_.want(query, [this, place](const Result<QueryAnswer>& answer) {
        take(answer.ok() ? pickedOf(*answer, place) : answer.error(), picked_);
    });
}

void NumbersData::forgetPicked() {
    pickQuery_.drop();
    picked_ = {};
}

void NumbersData::forget() {
    for (auto* query : {&wholeQuery_, &selectedQuery_, &seriesQuery_, &histogramQuery_, &pickQuery_})
        query->drop();
    whole_ = {};
    selected_ = {};
    series_ = {};
    histogram_ = {};
    picked_ = {};
}

}  // namespace mote::client
