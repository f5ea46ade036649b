// SPDX-License-Identifier: GPL-3.0-or-later
//
// FileBrowser: the page of the dataset browser on which a file of a root becomes a dataset: folders, what a
// file holds, and the options of the job that prepares it. Main thread, within a Dear ImGui frame; what it
// has asked is answered within Connection::poll().
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/shared/connection.h"
#include "client/view/datasets/job_form.h"
#include "client/view/datasets/list_rows.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::client {

/// How files of the server are asked for.
struct FileLine {
    template <class T>
    using Reply = Connection::Reply<T>;

    std::function<void(const std::string& folder, std::uint64_t first, Reply<proto::Folder>)> list;
    std::function<std::uint64_t(const proto::LookAtFile&, Reply<proto::Look>)> look;  ///< what cancel takes
    std::function<void(std::uint64_t look)> cancel;
    std::function<std::string()> whyNot;  ///< one sentence, if the server lists no files; else empty
};

/// A line over a connection, which outlives it. `learn` is told of what has come, before it is shown.
FileLine fileLineOf(Connection& connection, std::function<void(const google::protobuf::Message&)> learn);

/// What a folder holds, page by page, and which of it holds the words that were typed, in an order.
class FolderList {
  public:
    enum class Column { name, size, changed };

    /// A page: the first one is of another folder, or of what it holds by now.
    void take(const proto::Folder& page);
    const std::string& folder() const { return folder_; }
    const std::vector<proto::Folder::Entry>& entries() const { return entries_; }
    const std::vector<std::string>& notes() const { return notes_; }
    bool complete() const { return entries_.size() >= total_; }
    /// Places in entries(); the same question is answered at once.
    const std::vector<int>& find(std::string_view typed, Column column, bool descending);

  private:
    std::string folder_;
    std::vector<proto::Folder::Entry> entries_;
    std::vector<std::string> notes_;
    std::uint64_t total_ = 0;
    RowSearch rows_;
};

class FileBrowser {
  public:
    /// What the user wants: a dataset to be opened, or one to be made.
    struct Choice {
        std::string dataset;
        std::optional<proto::JobRequest> job = {};
    };

    explicit FileBrowser(FileLine line) : line_(std::move(line)) {}

    /// It is seen from now on: what it shows is asked for anew.
    void begin();
    /// It is seen no more: nothing is looked at for it.
    void rest();
    /// Draws it within a popup of the browser. `scale`: pixels to a screen coordinate.
    std::optional<Choice> draw(float scale);

  private:
    void go(const std::string& folder);
    void askPage(std::uint64_t first);
    void goUp();
    void lookAt(const std::vector<std::string>& inputs);
    void endLook();
    void take(const proto::Look& look);
    void chooseFound(int found);
    void chooseBecoming(int becoming);
    std::string pathOf(const std::string& name) const;
    bool isTaken(const std::string& path) const;
    std::vector<std::string> inputsOf(int row) const;
    std::string nameOf(int row) const;
    const proto::Folder::Entry* entryOf(int row) const;
    void enter(int row);

    void drawWay();
    void drawList(float scale);
    void drawRow(int row);
    void drawContent();
    void drawFound(const proto::Look::Found& found);
    void drawForm();
    bool drawAxes(JobForm::Field& field) const;
    void drawField(JobForm::Field& field) const;
    void drawOutput();
    void prepare();

    /// Rows above those of what the folder holds.
    enum class Above { up, folder, files };
    std::vector<Above> rowsAbove() const;

    FileLine line_;
    FolderList list_;
    std::string wanted_;       // the folder that is asked for
    std::uint64_t asked_ = 0;  // counts what was asked for: older answers are none
    bool listing_ = false, entered_ = false, focus_ = false, emptyBefore_ = true, first_ = true;
    std::string listError_;
    std::array<char, 128> typed_{};
    std::string sought_;
    FolderList::Column column_ = FolderList::Column::name;
    bool descending_ = false;
    std::vector<int> found_;
    std::vector<Above> above_;
    std::optional<int> row_;  // that is marked; none: the list is still to come

    std::string input_;                // that is looked at, "ROOT/PATH"; empty: none
    std::vector<std::string> inputs_;  // all of the run whose first it is
    std::optional<std::uint64_t> looking_;
    std::uint64_t looks_ = 0;
    std::optional<proto::Look> look_;
    std::string lookError_, formError_;
    double markedAt_ = 0.0;  // seconds; it is looked at once it has been marked for a moment
    bool lookWaits_ = false;
    float formHeight_ = 0.0F;  // when it was drawn last, pixels; 0: it was not
    int chosenFound_ = 0, chosenBecoming_ = 0;
    std::vector<Becoming> becomings_;
    JobForm form_;
    std::optional<Choice> choice_;
};

}  // namespace mote::client
