// SPDX-License-Identifier: GPL-3.0-or-later
//
// NumbersData: what is known of the numbers behind the picture, and the questions for what is not. Each kind
// of number is asked for anew when what it depends on has changed; the last answer stays until another is
// there, with the step that it belongs to. Owned by the numbers editor; main thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/shared/numbers.h"
#include "client/shared/picked_point.h"
#include "client/view/numbers/histogram_view.h"
#include "client/view/numbers/latest_query.h"
#include "protocol/mote.pb.h"

namespace mote::client {

/// What the panel and its windows show now.
struct NumbersWanted {
    std::string dataset;  ///< "ROOT/NAME"
    std::uint32_t step = 0;
    std::optional<proto::Selection> selection = {};  ///< without names
    bool whole = false;       ///< also the statistics of the whole step, which the manifest lacks
    std::string series = {};  ///< a statistic of it over all steps; empty: none
    std::optional<proto::HistogramQuery> histogram = {};
    bool histogramOfSelection = false;
    bool moving = false;  ///< the hand is still on it: nothing of all steps is asked for
};

class NumbersData {
  public:
    /// A kind of number: the last answer, or why there is none.
    template <class T>
    struct Known {
        std::optional<T> value;
        std::string failure;  ///< one sentence; empty: none
        bool waits = false;   ///< for a newer one
    };

    explicit NumbersData(const QueryLine& line);

    /// Asks for what is wanted and not known or asked for yet.
    void want(const NumbersWanted& wanted);
    /// Asks for a point; the dataset is that of `view`'s first layer.
    void pick(const proto::PickQuery& place);
    void forgetPicked();
    /// The server is another one, or knows other datasets.
    void forget();

    Known<StepStatistics> whole() const { return known(whole_, wholeQuery_); }
    Known<StepStatistics> selected() const { return known(selected_, selectedQuery_); }
    /// By step; NaN where it is not known.
    Known<std::vector<double>> series() const { return known(series_, seriesQuery_); }
    Known<StepHistogram> histogram() const { return known(histogram_, histogramQuery_); }
    /// An answer without a value: there is no point.
    Known<std::optional<PickedPoint>> picked() const { return known(picked_, pickQuery_); }

  private:
    template <class T>
    static Known<T> known(const Known<T>& last, const LatestQuery& query) {
        return {last.value, last.failure, query.waits()};
    }
    void wantWhole(const NumbersWanted& wanted);
    void wantSelected(const NumbersWanted& wanted);
    void wantSeries(const NumbersWanted& wanted);
    void wantHistogram(const NumbersWanted& wanted);

    std::string dataset_;
    Known<StepStatistics> whole_;
    Known<StepStatistics> selected_;
    Known<std::vector<double>> series_;
    Known<StepHistogram> histogram_;
    Known<std::optional<PickedPoint>> picked_;
    // Last: no answer comes to what is gone.
    LatestQuery wholeQuery_, selectedQuery_, seriesQuery_, histogramQuery_, pickQuery_;
};

}  // namespace mote::client
