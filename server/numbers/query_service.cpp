// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/numbers/query_service.h"

#include <oneapi/tbb/task_arena.h>
#include <sys/resource.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "server/numbers/query_run.h"
#include "storage/caught_error.h"

namespace mote::server {
namespace {

// Steps below the other threads' priority: if pictures are drawn, a thread of this has a tenth of a core.
constexpr int niceness = 10;
constexpr std::uint64_t memoryShare = 4;

}  // namespace

struct QueryService::Query {
    proto::Query message;
    Answered answered;
    std::unique_ptr<QueryRun> run;  // of the thread that works on it
    std::atomic<bool> cancelled{false};

    bool quick() const { return message.has_pick(); }
};

class QueryService::Impl {
  public:
    Impl(RunSource& runs, std::shared_ptr<storage::BlockBudget> budget, std::uint64_t memory,
         unsigned threads)
        : memory_(std::make_shared<QueryMemory>(std::move(budget), memory)),
          selections_(memory_),
          context_{runs, memory_, selections_},
          arena_(static_cast<int>(threads), 1, tbb::task_arena::priority::low) {
        for (unsigned i = 0; i < threads; ++i) threads_.emplace_back([this] { work(arena_, false); });
        // Picks take milliseconds, and somebody holds the mouse: nothing long is before them.
        threads_.emplace_back([this] { work(quickArena_, true); });
    }

    ~Impl() {
        {
            const std::lock_guard lock(mutex_);
            stopping_ = true;
        }
        wake_.notify_all();
        for (auto& thread : threads_) thread.join();
    }

    void enqueue(const Ticket& ticket) {
        {
            const std::lock_guard lock(mutex_);
            (ticket->quick() ? quick_ : waiting_).push_back(ticket);
        }
        wake_.notify_all();
    }

    std::size_t underWay() const {
        const std::lock_guard lock(mutex_);
        return waiting_.size() + quick_.size() + working_;
    }

  private:
    void work(tbb::task_arena& arena, bool quick) {
        ::setpriority(PRIO_PROCESS, 0, ::getpriority(PRIO_PROCESS, 0) + niceness);  // on Linux a thread's own
        auto& line = quick ? quick_ : waiting_;
        std::unique_lock lock(mutex_);
        for (;;) {
            wake_.wait(lock, [&] { return stopping_ || !line.empty(); });
            if (stopping_) return;
            auto query = std::move(line.front());
            line.pop_front();
            ++working_;
            lock.unlock();
            if (!query->cancelled) answer(*query, arena);
            query = nullptr;
            lock.lock();
            --working_;
        }
    }

    void answer(Query& query, tbb::task_arena& arena) {
        const auto cancelled = [&] {
            return query.cancelled.load(std::memory_order_relaxed) ||
                   stopping_.load(std::memory_order_relaxed);
        };
        auto answer = arena.execute([&]() -> Result<QueryAnswer> {
            try {
                if (!query.run) {
                    MOTE_ASSIGN_OR_RETURN(query.run, QueryRun::make(query.message, context_));
                }
                return query.run->next(cancelled);
            } catch (const std::exception&) {
                return storage::caughtError(
                    {ErrorCode::resourceExhausted, "query", "there is not enough memory to answer it"});
            }
        });
        if (!answer.ok() || answer->message.last()) query.run = nullptr;
        if (!cancelled()) query.answered(std::move(answer));
    }

    const std::shared_ptr<QueryMemory> memory_;
    SelectionResults selections_;
    QueryContext context_;
    tbb::task_arena arena_;
    tbb::task_arena quickArena_{1, 1};

    mutable std::mutex mutex_;
    std::condition_variable wake_;
    // Under the mutex.
    std::deque<Ticket> waiting_, quick_;
    std::size_t working_ = 0;
    std::atomic<bool> stopping_{false};  // also read without

    std::vector<std::thread> threads_;
};

QueryService::QueryService(RunSource& runs, std::shared_ptr<storage::BlockBudget> budget,
                           std::uint64_t memory, unsigned threads)
    : impl_(std::make_unique<Impl>(runs, std::move(budget), memory, std::max(1U, threads))) {}

QueryService::~QueryService() = default;

QueryService::Ticket QueryService::ask(proto::Query query, Answered answered) {
    auto ticket = std::make_shared<Query>();
    ticket->message = std::move(query);
    ticket->answered = std::move(answered);
    impl_->enqueue(ticket);
    return ticket;
}

void QueryService::proceed(const Ticket& ticket) {
    if (!ticket->cancelled) impl_->enqueue(ticket);
}

void QueryService::cancel(const Ticket& ticket) {
    ticket->cancelled = true;
}

std::size_t QueryService::underWay() const {
    return impl_->underWay();
}

unsigned queryThreads(unsigned processors) {
    return std::max(1U, processors / 2);
}

std::uint64_t queryMemory(std::uint64_t data) {
    return data / memoryShare;
}

}  // namespace mote::server
