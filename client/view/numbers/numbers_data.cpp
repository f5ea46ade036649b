// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/numbers_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace mote::client {
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
