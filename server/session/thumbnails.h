// SPDX-License-Identifier: GPL-3.0-or-later
//
// Thumbnails: small pictures of datasets as they are first seen, for lists of them. Each is drawn while
// nobody waits for another picture, once for all clients, and kept in the server's state directory until the
// dataset changes or the room is needed. What has to be read or drawn is on a thread of its own.
#pragma once

#include <asio/any_io_executor.hpp>
#include <asio/thread_pool.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "server/data/step_source.h"
#include "server/frames/crash_record.h"
#include "server/frames/render_service.h"

namespace mote::server {

struct Thumbnail {
    static constexpr std::uint32_t width = 192, height = 108;  ///< pixels
    std::vector<std::uint8_t> jpeg;
};

/// Thumbnails in a folder of the server's own, by key: 32 hexadecimal digits. Each file appears by one rename
/// and holds the hash of its bytes. Where all take too much, those go that were used longest ago, also by
/// servers before. What cannot be kept is not: it is said once, and thumbnails are drawn anew. One thread.
class ThumbnailFiles {
  public:
    static constexpr std::uint64_t usualMost = std::uint64_t{128} << 20;  ///< bytes

    /// Makes the folder, or takes what is there. `most`: bytes of all files.
    explicit ThumbnailFiles(std::filesystem::path folder, std::uint64_t most = usualMost);

    /// Nothing where there is none; one that is damaged is removed.
    std::optional<Thumbnail> find(const std::string& key);
    void keep(const std::string& key, const Thumbnail& thumbnail);
    std::uint64_t bytes() const { return bytes_; }

  private:
    struct File {
        std::uint64_t bytes;
        std::list<std::string>::iterator place;
    };
    void look();
    void add(const std::string& key, std::uint64_t bytes);
    void forget(const std::string& key);
    std::filesystem::path path(const std::string& key) const;

    const std::filesystem::path folder_;
    const std::uint64_t most_;
    bool usable_ = false, saidFull_ = false;
    std::uint64_t bytes_ = 0;
    std::list<std::string> order_;  // keys, those that were used last in front
    std::map<std::string, File> files_;
};

class Thumbnails {
  public:
    using Answer = Result<std::shared_ptr<const Thumbnail>>;
    using Answered = std::function<void(Answer)>;

    /// `data` and `render` outlive stop(); `crashes` may be null: nothing is known.
    Thumbnails(StepSource& data, RenderService& render, const CrashRecord* crashes,
               std::filesystem::path folder);
    /// After stop(), and after the end of `render`.
    ~Thumbnails();
    Thumbnails(const Thumbnails&) = delete;
    Thumbnails& operator=(const Thumbnails&) = delete;

    /// Any thread; returns at once. `answered` is called on the service's thread, unless the service ends
    /// first, or nobody holds `wanted` any more: then nothing is drawn for it either. Those that were asked
    /// for last are drawn first. Errors: notFound, unsupported (no layer draws it by itself), those of its
    /// picture.
    void ask(std::string dataset, std::weak_ptr<const void> wanted, Answered answered);
    /// Once. Waits for what the thread does; nothing is answered any more.
    void stop();

  private:
    struct Asker {
        std::weak_ptr<const void> wanted;
        Answered answered;
    };
    /// One that is not kept, and who waits for it.
    struct Missing {
        std::string dataset, key;
        std::vector<Asker> askers;

        void join(Asker asker);
        /// Whether anybody waits still; forgets the others.
        bool wanted();
    };

    RenderEvents events();
    void look(const std::string& dataset, Asker asker);
    void drawNext();
    Status draw(const Missing& missing);
    void drawn(RenderedFrame frame);
    void settle(std::uint64_t view, const Answer& answer);
    static void tell(const Missing& whom, const Answer& answer);

    StepSource& data_;
    RenderService& render_;
    const CrashRecord* const crashes_;
    // The thread's own.
    ThumbnailFiles files_;
    std::vector<Missing> missing_;    // the latest at the end
    std::optional<Missing> drawing_;  // whose picture is under way
    std::uint64_t view_ = 0;          // that picture's

    asio::thread_pool thread_{1};
};

/// What one client has asked for and not been answered, of bounded number. Owned by its session, on the
/// executor's thread.
class SessionThumbnails {
  public:
    static constexpr std::size_t mostAsked = 64;

    struct Answered {
        std::uint64_t request;
        std::string dataset;
        Thumbnails::Answer answer;
    };

    /// `service` may be null: then nothing is answered.
    SessionThumbnails(Thumbnails* service, asio::any_io_executor executor);

    /// `ready` is called when take() has something. Returns the request that is given up for this one, where
    /// there are too many: the oldest. Errors: unsupported.
    Result<std::optional<std::uint64_t>> ask(std::uint64_t request, const std::string& dataset,
                                             std::function<void()> ready);
    std::optional<Answered> take();
    void close() { desk_ = nullptr; }

  private:
    struct Asked {
        std::uint64_t request;
        std::string dataset;
        std::optional<Thumbnails::Answer> answer;
    };
    /// In the order in which they were asked for; each is held as long as it is wanted.
    using Desk = std::list<std::shared_ptr<Asked>>;

    Thumbnails* const service_;
    const asio::any_io_executor executor_;
    std::shared_ptr<Desk> desk_ = std::make_shared<Desk>();  // null once closed
};

}  // namespace mote::server
