// Datasets that grow by rows while others read them: whole chunks, compressed here and handed to HDF5 as they are.
#pragma once

#include <libdeflate.h>

#include <memory>
#include <span>
#include <vector>

#include "host/record/hdf5.hpp"

namespace lockstep {

/// Makes what HDF5's filters "shuffle" and "deflate" make of a chunk, so that every reader of HDF5 can read it, in a
/// tenth of the time: the low bytes of numbers that move are noise, so they are stored and only the high ones deflated,
/// unless much repeats from row to row.
class ChunkPacker {
 public:
  ChunkPacker();

  /// `elements` of `element_bytes` bytes each in rows of `row_elements`. The result is good until the next call.
  std::span<const unsigned char> pack(std::span<const unsigned char> elements, std::size_t element_bytes,
                                      std::size_t row_elements);

 private:
  void shuffle(std::span<const unsigned char> elements, std::size_t element_bytes);

  struct Free {
    void operator()(libdeflate_compressor* compressor) const { libdeflate_free_compressor(compressor); }
  };
  std::unique_ptr<libdeflate_compressor, Free> compressor_;
  std::vector<unsigned char> shuffled_, packed_;
};

/// A dataset of rows of one shape. Chunks hold a fixed number of rows, and of a part of each where rows are long.
class GrowingRows {
 public:
  GrowingRows() = default;
  /// `row`: the extent of one row. `type` is that of an element in the file, which has the layout of memory.
  GrowingRows(hid_t file, const char* name, hid_t type, std::vector<hsize_t> row, hsize_t rows_per_chunk);

  /// Appends at most as many rows as a chunk holds; all calls but the last must bring as many. Readers see them when
  /// this returns.
  void append(const void* rows, hsize_t count, ChunkPacker& packer);

  /// Appends any number of rows; a chunk that was not full is written again.
  void append_any(const void* rows, hsize_t count);

  /// Leaves the dataset as the file has it: closing it could write.
  void abandon() { dataset_.release(); }

 private:
  h5::Handle dataset_;
  std::size_t element_bytes_ = 0, row_elements_ = 1;
  std::vector<hsize_t> row_, chunk_;  // extents of a row and of a chunk
  hsize_t rows_ = 0;
  std::vector<unsigned char> piece_;
};

}  // namespace lockstep
