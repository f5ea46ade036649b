// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the fuzzers and the replay of their corpora share: bytes that others may have made, read as the
// programs read them. Each returns the error's sentence, "" where all was read, and aborts where a reader
// breaks its contract; none leaves anything behind. Functions without state of their own; one thread.
#pragma once

#include <string>
#include <string_view>

namespace mote::test {

/// A dataset on disk: files one after the other, each "NAME SIZE\n" and its bytes. Hashes are made anew, as
/// an enemy would, everything is verified, and then loaded as the server does. Contract: what verifies has a
/// box that is finite.
std::string datasetInput(std::string_view input);

/// Several files and a reader of theirs: a line, "particles FORMAT NAME..." or "volume FORMAT NAME [FIELD]",
/// then the files, as of a dataset. Contracts: as of one file.
std::string filesInput(std::string_view input);

/// A file of HDF5: its first line says who reads it, "particles FORMAT [SPECIES...]" or "volume FORMAT
/// [FIELD]", the rest what is in it (hdf5_text.h). Contracts: as of other files.
std::string hdf5Input(std::string_view input);

/// A mesh: its first line names the format (obj, off, ply, stl, or auto, which may be gzipped), the rest is
/// the file. Contract: every triangle has three of the vertices, every vertex is finite.
std::string meshInput(std::string_view input);

/// A stack of pictures: its first line names the format and what is opened, a name or "." for all; each
/// further line is a picture (picture_text.h). Contracts: as of a volume.
std::string picturesInput(std::string_view input);

/// JSON of the schema: its first line says of what (view, script, job, selection, manifest). Contract: what
/// was taken and made a message again is taken again, and every frame of a film is a valid view.
std::string sceneInput(std::string_view input);

/// A file of particles: its first line names the format (csv, impactz, impactt, npy, npz, sdds, astra,
/// tracewin, deck, track or auto), the rest is the file, which never touches the disk. Contract: columns are
/// as long as they were asked for, weights not negative.
std::string tableInput(std::string_view input);

/// A volume: its first line names the format (auto, nrrd, metaimage, nifti, vti or raw, which stands for
/// 3 x 4 x 5 of i16), the rest is the file. Contract: shapes are within bounds, and slices that are read
/// again are the same.
std::string volumeInput(std::string_view input);

/// A stream of the protocol: its first line says whose (client or server), the rest are greeting and frames.
/// Contract: nothing longer than its limit is taken, a message that was taken is one when it is written
/// again, and filtered pixels come back.
std::string wireInput(std::string_view input);

}  // namespace mote::test
