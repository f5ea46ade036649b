// SPDX-License-Identifier: GPL-3.0-or-later
//
// DatasetBrowser: all datasets of the server in a list with pictures, which is searched as one types and
// sorted by what its columns hold; one of them is chosen to be opened, added or put in another's place. What
// it takes to draw grows with what is seen of it, not with how many there are. Main thread, within a Dear
// ImGui frame.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/view/datasets/dataset_thumbnails.h"
#include "client/view/datasets/file_browser.h"
#include "client/view/datasets/list_rows.h"
#include "client/view/over_picture.h"
#include "protocol/mote.pb.h"

namespace mote::client {

/// Finds datasets by words that their names, kinds and titles hold, and sorts them.
class DatasetIndex {
  public:
    enum class Column { picture, name, kind, steps, particles, size, prepared, title };

    void setCatalogue(const proto::Catalogue& catalogue);
    /// Places in the catalogue of those that hold all words, in order; the same question is answered at once.
    const std::vector<int>& find(std::string_view typed, Column column, bool descending);

  private:
    std::vector<proto::Catalogue::Entry> entries_;
    RowSearch rows_;
};

class DatasetBrowser {
  public:
    enum class Use { open, add, replace };
    struct Choice {
        Use use;
        std::string dataset;
        std::optional<proto::JobRequest>
            job;  ///< a dataset that is to be made, in place of one that is there
    };

    DatasetBrowser(std::filesystem::path connection, FileLine files)
        : thumbnails_(std::move(connection)), files_(std::move(files)) {}

    void open(Use use);
    /// The other page: a file becomes a dataset.
    void openFiles();
    bool isOpen() const { return open_ || opening_; }
    /// The catalogue is another now.
    void setCatalogue(const proto::Catalogue& catalogue);
    /// Draws it over the picture while it is open; what the user wants.
    std::optional<Choice> draw(const PictureArea& area);

  private:
    void drawList(float scale);
    void drawRow(int row, float height);
    void showPage(bool files);
    void drawPages();
    std::optional<Choice> drawDatasets(float scale);
    std::optional<Choice> drawFiles(float scale);

    DatasetIndex index_;
    DatasetThumbnails thumbnails_;
    FileBrowser files_;
    bool filesShown_ = false, focus_ = false;
    proto::Catalogue catalogue_;
    Use use_ = Use::open;
    std::array<char, 128> typed_{};
    DatasetIndex::Column column_ = DatasetIndex::Column::name;
    bool descending_ = false;
    std::string sought_;  // what the list is of
    int row_ = 0;         // that the keys have come to
    bool opening_ = false, open_ = false;
    std::vector<int> found_;
    std::vector<const proto::Catalogue::Entry*> seen_;
    std::optional<std::string> chosen_;
};

}  // namespace mote::client
