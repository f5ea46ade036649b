// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/metrics/exposition.h"

#include <prometheus/text_serializer.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <limits>

namespace mote::server {
namespace {

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using prometheus::MetricType;
using Labels = std::vector<ClientMetric::Label>;

ClientMetric number(MetricType type, double value, Labels labels = {}) {
    ClientMetric metric;
    metric.label = std::move(labels);
    (type == MetricType::Counter ? metric.counter.value : metric.gauge.value) = value;
    return metric;
}

MetricFamily one(std::string name, std::string help, MetricType type, double value) {
    return {std::move(name), std::move(help), type, {number(type, value)}};
}
MetricFamily counter(std::string name, std::string help, const Count& count) {
    return one(std::move(name), std::move(help), MetricType::Counter, static_cast<double>(count.value()));
}
MetricFamily gauge(std::string name, std::string help, double value) {
    return one(std::move(name), std::move(help), MetricType::Gauge, value);
}

/// One series a label's value.
MetricFamily labelled(std::string name, std::string help, MetricType type, const std::string& label,
                      const std::vector<std::pair<std::string, double>>& values) {
    MetricFamily family{std::move(name), std::move(help), type, {}};
    for (const auto& [text, value] : values) family.metric.push_back(number(type, value, {{label, text}}));
    return family;
}

ClientMetric histogram(const std::string& part, const TimeHistogram& times) {
    ClientMetric metric;
    metric.label = {{"part", part}};
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i <= TimeHistogram::bounds.size(); ++i) {
        sum += times.inBucket(i);
        const bool last = i == TimeHistogram::bounds.size();
        metric.histogram.bucket.push_back(
            {sum, last ? std::numeric_limits<double>::infinity() : TimeHistogram::bounds[i]});
    }
    metric.histogram.sample_count = sum;
    metric.histogram.sample_sum = times.sum();
    return metric;
}

MetricFamily frameTimes(const Metrics& metrics) {
    return {"mote_frame_seconds",
            "How long parts of making a frame took",
            MetricType::Histogram,
            {histogram("queued", metrics.queued), histogram("plan", metrics.plan),
             histogram("render", metrics.render), histogram("encode", metrics.encode),
             histogram("total", metrics.total)}};
}

MetricFamily errorsByCode(const Metrics& metrics) {
    std::vector<std::pair<std::string, double>> values;
    for (std::size_t i = 0; i < Metrics::errorCodes; ++i) {
        values.emplace_back(name(static_cast<ErrorCode>(i)), metrics.errors[i].value());
    }
    return labelled("mote_errors_total", "Failures that clients were told", MetricType::Counter, "code",
                    values);
}

/// Under the names that Prometheus' own clients use.
std::vector<MetricFamily> ofThisProcess() {
    std::uint64_t size = 0, resident = 0;
    std::ifstream("/proc/self/statm") >> size >> resident;
    const auto entries = [](const char* folder) {
        std::error_code code;
        const std::filesystem::directory_iterator all(folder, code);
        return static_cast<double>(code ? 0 : std::distance(begin(all), end(all)));
    };
    const auto page = static_cast<double>(::sysconf(_SC_PAGESIZE));
    return {gauge("process_resident_memory_bytes", "Memory of the serving process",
                  static_cast<double>(resident) * page),
            gauge("process_open_fds", "Descriptors that it has open", entries("/proc/self/fd")),
            gauge("process_threads", "Threads that it has", entries("/proc/self/task"))};
}

}  // namespace

std::string toPrometheus(const Metrics& metrics, const Gauges& gauges) {
    const std::vector<std::pair<std::string, double>> jobs(gauges.jobs.begin(), gauges.jobs.end());
    std::vector<MetricFamily> all{
        {"mote_info",
         "The server's version and device",
         MetricType::Gauge,
         {number(MetricType::Gauge, 1.0, {{"version", gauges.version}, {"device", gauges.device}})}},
        gauge("mote_healthy", "1 where /healthz says 200", gauges.healthy ? 1.0 : 0.0),
        gauge("mote_sessions", "Connections with a token", static_cast<double>(gauges.sessions)),
        gauge("mote_startups", "Connections that have shown no token yet",
              static_cast<double>(gauges.startups)),
        counter("mote_sessions_total", "Sessions that began with the right token", metrics.sessions),
        labelled("mote_refused_total", "Connections that were refused", MetricType::Counter, "reason",
                 {{"full", static_cast<double>(metrics.refusedFull.value())},
                  {"startup", static_cast<double>(metrics.refusedStartup.value())},
                  {"token", static_cast<double>(metrics.refusedToken.value())}}),
        labelled("mote_frames_total", "Pictures that were sent", MetricType::Counter, "final",
                 {{"false", static_cast<double>(metrics.framesMoving.value())},
                  {"true", static_cast<double>(metrics.framesFinal.value())}}),
        counter("mote_sent_bytes_total", "Bytes of messages and pictures that were sent", metrics.bytesSent),
        frameTimes(metrics),
        errorsByCode(metrics),
        labelled("mote_jobs", "Jobs that are remembered, by state", MetricType::Gauge, "state", jobs),
        gauge("mote_queries", "Queries for numbers that are under way", static_cast<double>(gauges.queries)),
        gauge("mote_datasets", "Datasets in the catalogue", static_cast<double>(gauges.datasets)),
        gauge("mote_data_bytes", "Data of datasets in memory", static_cast<double>(gauges.dataBytes)),
        gauge("mote_data_limit_bytes", "What they may take", static_cast<double>(gauges.dataLimit)),
    };
    for (auto& family : ofThisProcess()) all.push_back(std::move(family));
    return prometheus::TextSerializer().Serialize(all);
}

}  // namespace mote::server
