#include "host/record/hdf5.hpp"

namespace lockstep::h5 {

namespace {

// The innermost message: "... error message = 'No space left on device' ..." says most of all.
std::string last_message() {
  std::string message;
  const auto keep_first = [](unsigned n, const H5E_error2_t* error, void* out) -> herr_t {
    if (n == 0 && error->desc) *static_cast<std::string*>(out) = error->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_first, &message);
  H5Eclear2(H5E_DEFAULT);
  const std::string quoted = "error message = '";
  if (const auto start = message.find(quoted); start != std::string::npos) {
    const auto first = start + quoted.size(), end = message.find('\'', first);
    message = message.substr(first, end == std::string::npos ? end : end - first);
  }
  return message.empty() ? "HDF5 does not say why" : message;
}

void expect_class(hid_t type, H5T_class_t wanted, const char* name) {
  if (H5Tget_class(type) != wanted) throw Failed(std::string(name) + " is of another type");
}

constexpr std::size_t longest_text = 256u << 20;

// A text of fixed length, padded with zeros. One of variable length would need memory of HDF5's.
std::size_t length_of_text(hid_t type, const char* name) {
  expect_class(type, H5T_STRING, name);
  const std::size_t length = H5Tget_size(type);
  if (check(H5Tis_variable_str(type)) > 0 || length > longest_text)
    throw Failed(std::string(name) + " is no text of fixed length");
  return length;
}

void cut_at_zero(std::string& text) {
  if (const auto end = text.find('\0'); end != std::string::npos) text.resize(end);
}

void expect_one_element(hid_t space, const char* name) {
  if (check(H5Sget_simple_extent_npoints(space)) != 1) throw Failed(std::string(name) + " is not one value");
}

Handle open_attribute(hid_t object, const char* name) {
  if (H5Aexists(object, name) <= 0) throw Failed(std::string("has no attribute ") + name);
  return Handle(H5Aopen(object, name, H5P_DEFAULT));
}

// A file is read for what it holds: links, storage and virtual datasets may name any file of the machine.
void expect_in_file(hid_t group, const char* name) {
  H5L_info_t link;
  check(H5Lget_info(group, name, &link, H5P_DEFAULT));
  if (link.type != H5L_TYPE_HARD)
    throw Failed(std::string(name) + " is a link, which recordings and problems have not");
}

// Deflate makes a thousandth of what repeats: what is larger than that has not been stored.
constexpr hsize_t most_packed = 1100;

void expect_stored_here(hid_t dataset, const char* name) {
  const Handle properties(H5Dget_create_plist(dataset)), type(H5Dget_type(dataset)), space(H5Dget_space(dataset));
  if (check(H5Pget_layout(properties)) == H5D_VIRTUAL || check(H5Pget_external_count(properties)) > 0)
    throw Failed(std::string(name) + " has its numbers in another file");
  const auto count = static_cast<hsize_t>(check(H5Sget_simple_extent_npoints(space)));
  if (count / most_packed * H5Tget_size(type) > H5Dget_storage_size(dataset))
    throw Failed(std::string(name) + " is not all there");
}

}  // namespace

void be_quiet() {
  // everything is closed by its owner; a file that a full disk left half written is better left alone (abandon)
  static const herr_t at_exit = H5dont_atexit();
  static_cast<void>(at_exit);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

void fail() { throw Failed(last_message()); }

void Handle::close() noexcept {
  if (id_ > 0) H5Idec_ref(id_);
  id_ = -1;
}

#define WORD(type, stored, native) \
  template <>                      \
  hid_t file_type<type>() {        \
    return stored;                 \
  }                                \
  template <>                      \
  hid_t memory_type<type>() {      \
    return native;                 \
  }
WORD(float, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT)
WORD(double, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE)
WORD(u32, H5T_STD_U32LE, H5T_NATIVE_UINT32)
WORD(std::uint64_t, H5T_STD_U64LE, H5T_NATIVE_UINT64)
#undef WORD

Handle text_type(std::size_t length) {
  Handle type(H5Tcopy(H5T_C_S1));
  check(H5Tset_size(type, length > 0 ? length : 1));
  check(H5Tset_cset(type, H5T_CSET_UTF8));
  check(H5Tset_strpad(type, H5T_STR_NULLPAD));
  return type;
}

Handle space(std::span<const hsize_t> extent) {
  return Handle(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr));
}

template <class Number>
void write_attribute(hid_t object, const char* name, Number value) {
  const Handle scalar(H5Screate(H5S_SCALAR));
  const Handle attribute(H5Acreate2(object, name, file_type<Number>(), scalar, H5P_DEFAULT, H5P_DEFAULT));
  check(H5Awrite(attribute, memory_type<Number>(), &value));
}

template <class Number>
Number read_attribute(hid_t object, const char* name) {
  const Handle attribute = open_attribute(object, name);
  const Handle type(H5Aget_type(attribute)), scalar(H5Aget_space(attribute));
  if (check(H5Tequal(type, file_type<Number>())) == 0) throw Failed(std::string(name) + " is of another type");
  expect_one_element(scalar, name);
  Number value = {};
  check(H5Aread(attribute, memory_type<Number>(), &value));
  return value;
}

template void write_attribute<u32>(hid_t, const char*, u32);
template void write_attribute<std::uint64_t>(hid_t, const char*, std::uint64_t);
template void write_attribute<float>(hid_t, const char*, float);
template void write_attribute<double>(hid_t, const char*, double);
template u32 read_attribute<u32>(hid_t, const char*);
template std::uint64_t read_attribute<std::uint64_t>(hid_t, const char*);
template float read_attribute<float>(hid_t, const char*);
template double read_attribute<double>(hid_t, const char*);

void write_attribute(hid_t object, const char* name, const std::string& text) {
  const Handle scalar(H5Screate(H5S_SCALAR)), type = text_type(text.size());
  const Handle attribute(H5Acreate2(object, name, type, scalar, H5P_DEFAULT, H5P_DEFAULT));
  check(H5Awrite(attribute, type, text.c_str()));
}

std::string read_text_attribute(hid_t object, const char* name) {
  const Handle attribute = open_attribute(object, name);
  const Handle type(H5Aget_type(attribute)), scalar(H5Aget_space(attribute));
  std::string text(length_of_text(type, name), '\0');
  expect_one_element(scalar, name);
  check(H5Aread(attribute, type, text.data()));
  cut_at_zero(text);
  return text;
}

void write_text(hid_t group, const char* name, const std::string& text) {
  const Handle scalar(H5Screate(H5S_SCALAR)), type = text_type(text.size());
  const Handle dataset(H5Dcreate2(group, name, type, scalar, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.c_str()));
}

std::string read_text(hid_t group, const char* name) {
  const Handle dataset = open_dataset(group, name);
  const Handle type(H5Dget_type(dataset)), scalar(H5Dget_space(dataset));
  std::string text(length_of_text(type, name), '\0');
  expect_one_element(scalar, name);
  check(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()));
  cut_at_zero(text);
  return text;
}

template <class Word>
void write_words(hid_t group, const char* name, const void* words, std::size_t rows, std::size_t columns) {
  const hsize_t extent[] = {rows, columns};
  const Handle dataset(
      H5Dcreate2(group, name, file_type<Word>(), space(extent), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  if (rows > 0) check(H5Dwrite(dataset, memory_type<Word>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, words));
}

template <class Word>
void read_words(hid_t group, const char* name, void* words, std::size_t rows, std::size_t columns) {
  const Handle dataset = open_dataset(group, name);
  const Handle type(H5Dget_type(dataset));
  if (check(H5Tequal(type, file_type<Word>())) == 0 || extent_of(dataset) != std::vector<hsize_t>{rows, columns})
    throw Failed(std::string(name) + " has another shape than the scene gives it");
  if (rows > 0) check(H5Dread(dataset, memory_type<Word>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, words));
}

template void write_words<u32>(hid_t, const char*, const void*, std::size_t, std::size_t);
template void write_words<float>(hid_t, const char*, const void*, std::size_t, std::size_t);
template void write_words<double>(hid_t, const char*, const void*, std::size_t, std::size_t);
template void read_words<u32>(hid_t, const char*, void*, std::size_t, std::size_t);
template void read_words<float>(hid_t, const char*, void*, std::size_t, std::size_t);
template void read_words<double>(hid_t, const char*, void*, std::size_t, std::size_t);

bool has(hid_t group, const char* name) { return H5Lexists(group, name, H5P_DEFAULT) > 0; }
bool has_attribute(hid_t object, const char* name) { return H5Aexists(object, name) > 0; }

Handle open_group(hid_t file, const char* name) {
  if (!has(file, name)) throw Failed(std::string("has no group ") + name);
  expect_in_file(file, name);
  return Handle(H5Gopen2(file, name, H5P_DEFAULT));
}

Handle open_dataset(hid_t group, const char* name) {
  if (!has(group, name)) throw Failed(std::string("has no dataset ") + name);
  expect_in_file(group, name);
  Handle dataset(H5Dopen2(group, name, H5P_DEFAULT));
  expect_stored_here(dataset, name);
  return dataset;
}

std::vector<hsize_t> extent_of(hid_t dataset) {
  const Handle space(H5Dget_space(dataset));
  std::vector<hsize_t> extent(static_cast<std::size_t>(check(H5Sget_simple_extent_ndims(space))));
  check(H5Sget_simple_extent_dims(space, extent.data(), nullptr));
  return extent;
}

Handle open_image(std::span<const unsigned char> bytes) {
  be_quiet();
  const Handle access(H5Pcreate(H5P_FILE_ACCESS));
  check(H5Pset_fapl_core(access, 1u << 16, false));
  // HDF5 copies the bytes and does not change them
  check(H5Pset_file_image(access, const_cast<unsigned char*>(bytes.data()), bytes.size()));
  return Handle(H5Fopen("image", H5F_ACC_RDONLY, access));
}

}  // namespace lockstep::h5
