// pocl's cache of kernels on disk, which pocl maps and parses without looking: of a torn file the process dies, as it
// does where the disk is full.
#pragma once

#include <filesystem>
#include <string>

#include "host/device/devices.hpp"

namespace lockstep {

bool is_pocl(const DeviceInfo& device);

/// Where pocl has it: POCL_CACHE_DIR, or below XDG_CACHE_HOME or HOME.
std::filesystem::path pocl_cache_folder();

/// Removes the programs that have a torn file, which pocl then builds again; how many.
unsigned remove_torn_programs(const std::filesystem::path& cache);

/// Before OpenCL is first asked. Torn programs are removed; where the disk of the cache takes no files, pocl is sent to
/// a folder of this process on another one. `note` is given a line for each. False where no disk takes kernels: pocl is
/// better not asked then.
bool prepare_pocl_cache(void (*note)(const std::string& line));

/// Whether a file is a shared library, or bitcode of LLVM, to its end.
bool is_whole_library(const std::filesystem::path& path);
bool is_whole_bitcode(const std::filesystem::path& path);

/// Keeps the libraries of kernels that are loaded. pocl unloads those that were not used lately, of more than 128, and
/// a process of many worlds would load them again for each launch.
void keep_loaded_kernels();

}  // namespace lockstep
