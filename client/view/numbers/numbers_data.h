// SPDX-License-Identifier: GPL-3.0-or-later
//
// NumbersData: what is known of the numbers behind the picture, and the questions for what is not. Each kind
// of number is asked for anew when what it depends on has changed; the last answer stays until another is
// there, with the step that it belongs to. Owned by the numbers editor; main thread.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "client/shared/connection.h"
#include "client/shared/numbers.h"
#include "client/view/numbers/histogram_view.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::client {

/// The answer to a PickQuery as a value, held to what was asked and to itself. Units as in
/// docs/NUMBERS.md.
struct PickedPoint {
    struct Value {
        std::string name, unit;
        double value = 0.0;
    };
    std::uint32_t step = 0;
    std::uint32_t layer = 0;   ///< of the view that was asked about
    std::uint64_t point = 0;   ///< in the dataset's order
    std::uint64_t row = 0;     ///< in the source
    double distance = 0.0;     ///< pixels from the place that was asked for
    glm::dvec3 position{0.0};  ///< layer space
    double density = 0.0;      ///< scaled log density of its leaf
    std::vector<Value> values;
    std::optional<std::uint64_t> id;
};

/// Returns nothing if there is no point. Errors: corrupt.
Result<std::optional<PickedPoint>> pickedOf(const QueryAnswer& answer, const proto::PickQuery& asked);

/// The way to a server: Connection::query and cancelQuery.
struct QueryLine {
    using Reply = Connection::Reply<QueryAnswer>;
    std::function<std::uint64_t(const proto::Query&, Reply)> ask;
    std::function<void(std::uint64_t)> cancel;
};

/// A question for numbers of which only the latest form matters: another one takes its place,
/// and the server hears that the one before is not wanted any more. Main thread.
class LatestQuery {
  public:
    explicit LatestQuery(QueryLine line) : line_(std::move(line)) {}
    ~LatestQuery() { drop(); }
    LatestQuery(const LatestQuery&) = delete;
    LatestQuery& operator=(const LatestQuery&) = delete;

    /// Asks, unless this is what was asked last; true if it asks. `reply` hears each answer until the
    /// last, or an error; it must not outlive what it is given.
    bool want(const proto::Query& query, QueryLine::Reply reply);
    /// Wants nothing any more; the same question is then a new one.
    void drop();
    /// An answer is still to come.
    bool waits() const { return asking_ != 0; }

  private:
    void hear(const Result<QueryAnswer>& answer, const QueryLine::Reply& reply);

    QueryLine line_;
    std::string asked_;  // the message's bytes; empty: nothing
    std::optional<std::uint64_t> request_;
    std::uint64_t asking_ = 0;  // the number of the question under way; 0: none
    std::uint64_t questions_ = 0;
};

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
    /// The values by step; NaN if one is not known.
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
