// The one place that includes HDF5: handles that close themselves, failures as exceptions, small pieces of files.
#pragma once

#include <hdf5.h>

#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "kernels/types.h"

namespace lockstep::h5 {

/// What HDF5 had to say. Those who know the file and what it is for turn it into an Error.
class Failed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Keeps HDF5 from printing its errors, and from closing files by itself at the end; for each thread that calls it.
void be_quiet();

/// Throws Failed with the innermost message of HDF5.
[[noreturn]] void fail();

/// What a call returned; throws Failed where that is a negative number.
template <class Result>
Result check(Result result) {
  if (result < 0) fail();
  return result;
}

/// An open file, group, dataset, type or list of properties.
class Handle {
 public:
  Handle() = default;
  /// Takes over what a call of HDF5 returned; throws Failed where that is no handle.
  explicit Handle(hid_t id) : id_(check(id)) {}
  ~Handle() { close(); }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)) {}
  Handle& operator=(Handle&& other) noexcept {
    close();
    id_ = std::exchange(other.id_, -1);
    return *this;
  }

  operator hid_t() const { return id_; }
  /// Leaves it open.
  hid_t release() { return std::exchange(id_, -1); }

 private:
  void close() noexcept;

  hid_t id_ = -1;
};

/// The type in a file (little-endian, whatever the machine) of the words of a buffer, and of a field.
template <class Word>
hid_t file_type();

/// The type in memory.
template <class Word>
hid_t memory_type();

Handle text_type(std::size_t length);
Handle space(std::span<const hsize_t> extent);

/// Scalars beside a group or dataset. Reading throws Failed for one that is missing or of another type.
template <class Number>
void write_attribute(hid_t object, const char* name, Number value);
template <class Number>
Number read_attribute(hid_t object, const char* name);
void write_attribute(hid_t object, const char* name, const std::string& text);
std::string read_text_attribute(hid_t object, const char* name);

/// A dataset of one text.
void write_text(hid_t group, const char* name, const std::string& text);
std::string read_text(hid_t group, const char* name);

/// A dataset of records: `rows` x `columns` words.
template <class Word>
void write_words(hid_t group, const char* name, const void* words, std::size_t rows, std::size_t columns);

/// Reads one of exactly this shape; throws Failed for another.
template <class Word>
void read_words(hid_t group, const char* name, void* words, std::size_t rows, std::size_t columns);

bool has(hid_t group, const char* name);
bool has_attribute(hid_t object, const char* name);
Handle open_group(hid_t file, const char* name);
Handle open_dataset(hid_t group, const char* name);

/// How long each dimension of a dataset is.
std::vector<hsize_t> extent_of(hid_t dataset);

/// Opens what is a file of HDF5 by its bytes, which stay in memory. Throws Failed.
Handle open_image(std::span<const unsigned char> bytes);

}  // namespace lockstep::h5
