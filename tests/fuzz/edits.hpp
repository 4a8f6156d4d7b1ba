// Changes to a file of HDF5 that a fuzzer's bytes ask for. Its own bytes are left to HDF5: what is tried here is a file
// that HDF5 reads and that says what it should not.
#pragma once

#include <array>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "host/record/hdf5.hpp"

namespace lockstep {

class Edits {
 public:
  explicit Edits(std::span<const unsigned char> bytes) : bytes_(bytes) {}

  /// Changes groups, datasets and attributes of an open file, eight bytes for each change.
  void apply(hid_t file) {
    while (bytes_.size() >= 8) {
      const std::string name = pick(file);
      try {
        change(file, name);
      } catch (const h5::Failed&) {
        // what is not there cannot be changed
      }
      bytes_ = bytes_.subspan(8);
    }
  }

 private:
  u32 number(std::size_t at) const { return bytes_[at] | u32{bytes_[at + 1]} << 8; }

  // One of all the objects of the file.
  std::string pick(hid_t file) const {
    std::vector<std::string> names;
    const auto add = [](hid_t, const char* name, const H5O_info_t*, void* out) -> herr_t {
      static_cast<std::vector<std::string>*>(out)->push_back(name);
      return 0;
    };
    H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_INC, add, &names, H5O_INFO_BASIC);
    return names.empty() ? "." : names[bytes_[1] % names.size()];
  }

  void change(hid_t file, const std::string& name) const {
    const h5::Handle object(H5Oopen(file, name.c_str(), H5P_DEFAULT));
    const bool is_dataset = H5Iget_type(object) == H5I_DATASET;
    switch (bytes_[0] % 5) {
      case 0: h5::check(H5Ldelete(file, name.c_str(), H5P_DEFAULT)); break;
      case 1: change_attribute(object); break;
      case 2:
        if (is_dataset) change_contents(object);
        break;
      case 3:
        if (is_dataset) replace<u32>(file, name);
        break;
      case 4:
        if (is_dataset) replace<float>(file, name);
        break;
    }
  }

  void change_attribute(hid_t object) const {
    const h5::Handle attribute(
        H5Aopen_by_idx(object, ".", H5_INDEX_NAME, H5_ITER_INC, bytes_[2] % 16, H5P_DEFAULT, H5P_DEFAULT));
    const h5::Handle type(H5Aget_type(attribute));
    std::vector<unsigned char> value(H5Tget_size(type));
    h5::check(H5Aread(attribute, type, value.data()));
    for (std::size_t i = 0; i < 4; ++i) value[(bytes_[3] + i) % value.size()] = bytes_[4 + i];
    h5::check(H5Awrite(attribute, type, value.data()));
  }

  void change_contents(hid_t dataset) const {
    const h5::Handle type(H5Dget_type(dataset));
    std::size_t size = H5Tget_size(type);
    for (const hsize_t n : h5::extent_of(dataset)) size *= n;
    if (size == 0 || size > 1u << 24) return;
    std::vector<unsigned char> contents(size);
    h5::check(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, contents.data()));
    for (std::size_t i = 0; i < 4; ++i) contents[(number(2) + i) % size] = bytes_[4 + i];
    h5::check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, contents.data()));
  }

  template <class Word>
  void replace(hid_t file, const std::string& name) const {
    const std::size_t rows = number(2) % 300, columns = number(4) % 40;
    const std::vector<u32> words(rows * columns, number(6));
    h5::check(H5Ldelete(file, name.c_str(), H5P_DEFAULT));
    h5::write_words<Word>(file, name.c_str(), words.data(), rows, columns);
  }

  std::span<const unsigned char> bytes_;
};

}  // namespace lockstep
