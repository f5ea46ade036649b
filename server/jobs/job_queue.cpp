// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_queue.h"

#include <asio/io_context.hpp>

#include "server/jobs/job_queue_impl.h"

namespace mote::server {

JobQueue::JobQueue(asio::io_context& context, JobSettings settings)
    : impl_(std::make_shared<Impl>(context, std::move(settings))) {}

JobQueue::~JobQueue() {
    impl_->stop();
}

Status JobQueue::start() {
    return impl_->start();
}

void JobQueue::stop() {
    impl_->stop();
}

Result<proto::JobStatus> JobQueue::submit(const proto::JobRequest& request) {
    return impl_->submit(request);
}

Status JobQueue::cancel(std::string_view id) {
    return impl_->cancel(id);
}

std::vector<proto::JobStatus> JobQueue::list() const {
    return impl_->list();
}

Result<proto::JobStatus> JobQueue::find(std::string_view id) const {
    return impl_->find(id);
}

void JobQueue::onChange(Listener listener) {
    impl_->onChange(std::move(listener));
}

}  // namespace mote::server
