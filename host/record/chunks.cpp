#include "host/record/chunks.hpp"

#include <algorithm>
#include <cstring>

namespace lockstep {

namespace {

// Rows that are longer are split along their first dimension: what repeats from row to row is to be within the 32 KiB
// that deflate looks back.
constexpr hsize_t longest_piece = 2048;
constexpr std::size_t longest_stored = 65535;  // of a stored block (RFC 1951)

// Bytes equal to those a row before, in a plane of bytes.
std::size_t repeated(std::span<const unsigned char> plane, std::size_t row) {
  std::size_t count = 0;
  for (std::size_t i = row; i < plane.size(); ++i) count += plane[i] == plane[i - row];
  return count;
}

// With the number of bytes known the compiler makes vectors of it.
template <std::size_t element_bytes>
void shuffle_words(const unsigned char* elements, std::size_t count, unsigned char* planes) {
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t byte = 0; byte < element_bytes; ++byte)
      planes[byte * count + i] = elements[i * element_bytes + byte];
}

}  // namespace

ChunkPacker::ChunkPacker() : compressor_(libdeflate_alloc_compressor(1)) {
  if (!compressor_) throw std::bad_alloc();
}

// The first bytes of all elements, then the second ones, and so on (HDF5's filter "shuffle").
void ChunkPacker::shuffle(std::span<const unsigned char> elements, std::size_t element_bytes) {
  const std::size_t count = elements.size() / element_bytes;
  shuffled_.resize(elements.size());
  if (element_bytes == 4) return shuffle_words<4>(elements.data(), count, shuffled_.data());
  if (element_bytes == 8) return shuffle_words<8>(elements.data(), count, shuffled_.data());
  for (std::size_t i = 0; i < elements.size(); ++i)
    shuffled_[i % element_bytes * count + i / element_bytes] = elements[i];
}

// A stream of zlib (RFC 1950): stored blocks, a block that libdeflate made, the checksum.
std::span<const unsigned char> ChunkPacker::pack(std::span<const unsigned char> elements, std::size_t element_bytes,
                                                 std::size_t row_elements) {
  shuffle(elements, element_bytes);
  const std::size_t plane = elements.size() / element_bytes;
  const bool is_noise = repeated(std::span(shuffled_).first(plane), row_elements) < plane / 4;
  const std::size_t stored = is_noise ? elements.size() - (element_bytes + 3) / 4 * plane : 0;

  const std::size_t rest = elements.size() - stored;
  const std::size_t blocks = (stored + longest_stored - 1) / longest_stored;
  packed_.resize(2 + stored + 5 * blocks + libdeflate_deflate_compress_bound(compressor_.get(), rest) + 4);
  unsigned char* out = packed_.data();
  *out++ = 0x78;
  *out++ = 0x01;
  for (std::size_t done = 0; done < stored;) {
    const std::size_t length = std::min(stored - done, longest_stored);
    *out++ = 0;  // a stored block, not the last one
    *out++ = static_cast<unsigned char>(length);
    *out++ = static_cast<unsigned char>(length >> 8);
    *out++ = static_cast<unsigned char>(~length);
    *out++ = static_cast<unsigned char>(~length >> 8);
    std::memcpy(out, shuffled_.data() + done, length);
    out += length;
    done += length;
  }
  const std::size_t room = static_cast<std::size_t>(packed_.data() + packed_.size() - out) - 4;
  out += libdeflate_deflate_compress(compressor_.get(), shuffled_.data() + stored, rest, out, room);
  const std::uint32_t checksum = libdeflate_adler32(1, shuffled_.data(), shuffled_.size());
  for (int shift = 24; shift >= 0; shift -= 8) *out++ = static_cast<unsigned char>(checksum >> shift);
  return {packed_.data(), out};
}

GrowingRows::GrowingRows(hid_t file, const char* name, hid_t type, std::vector<hsize_t> row, hsize_t rows_per_chunk)
    : element_bytes_(H5Tget_size(type)), row_(std::move(row)) {
  chunk_ = {rows_per_chunk};
  std::vector<hsize_t> current = {0}, most = {H5S_UNLIMITED};
  for (const hsize_t length : row_) {
    const bool is_first = current.size() == 1;
    const hsize_t pieces = is_first ? (length + longest_piece - 1) / longest_piece : 1;
    chunk_.push_back((length + pieces - 1) / pieces);
    current.push_back(length);
    most.push_back(length);
  }
  for (std::size_t i = 1; i < chunk_.size(); ++i) row_elements_ *= chunk_[i];
  const h5::Handle properties(H5Pcreate(H5P_DATASET_CREATE));
  h5::check(H5Pset_chunk(properties, static_cast<int>(chunk_.size()), chunk_.data()));
  h5::check(H5Pset_shuffle(properties));
  h5::check(H5Pset_deflate(properties, 1));
  const h5::Handle space(H5Screate_simple(static_cast<int>(current.size()), current.data(), most.data()));
  dataset_ = h5::Handle(H5Dcreate2(file, name, type, space, H5P_DEFAULT, properties, H5P_DEFAULT));
}

void GrowingRows::append(const void* rows, hsize_t count, ChunkPacker& packer) {
  std::vector<hsize_t> extent = {rows_ + count};
  extent.insert(extent.end(), row_.begin(), row_.end());
  h5::check(H5Dset_extent(dataset_, extent.data()));

  // bytes of a step along the first dimension of a row, which alone is split
  const hsize_t length = row_.empty() ? 1 : row_[0], piece = row_.empty() ? 1 : chunk_[1];
  const std::size_t item = element_bytes_ * row_elements_ / piece;
  const unsigned char* from = static_cast<const unsigned char*>(rows);
  for (hsize_t first = 0; first < length; first += piece) {
    const hsize_t here = std::min(piece, length - first);
    piece_.assign(chunk_[0] * piece * item, 0);
    for (hsize_t r = 0; r < count; ++r)
      std::memcpy(piece_.data() + r * piece * item, from + (r * length + first) * item, here * item);
    const auto packed = packer.pack(piece_, element_bytes_, row_elements_);
    std::vector<hsize_t> offset(extent.size(), 0);
    offset[0] = rows_;
    if (!row_.empty()) offset[1] = first;
    h5::check(H5Dwrite_chunk(dataset_, H5P_DEFAULT, 0, offset.data(), packed.size(), packed.data()));
  }
  h5::check(H5Dflush(dataset_));
  rows_ += count;
}

void GrowingRows::append_any(const void* rows, hsize_t count) {
  std::vector<hsize_t> extent = {rows_ + count}, start(1 + row_.size(), 0), added = {count};
  extent.insert(extent.end(), row_.begin(), row_.end());
  added.insert(added.end(), row_.begin(), row_.end());
  start[0] = rows_;
  h5::check(H5Dset_extent(dataset_, extent.data()));
  const h5::Handle type(H5Dget_type(dataset_)), in_file(H5Dget_space(dataset_)), in_memory = h5::space(added);
  h5::check(H5Sselect_hyperslab(in_file, H5S_SELECT_SET, start.data(), nullptr, added.data(), nullptr));
  h5::check(H5Dwrite(dataset_, type, in_memory, in_file, H5P_DEFAULT, rows));
  h5::check(H5Dflush(dataset_));
  rows_ += count;
}

}  // namespace lockstep
