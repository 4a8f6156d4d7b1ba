#include "bench/apart.hpp"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <memory>

#include "host/error.hpp"

namespace lockstep::bench {

namespace {

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Close>;

void write(std::FILE* file, const std::vector<double>& values) {
  const double count = static_cast<double>(values.size());
  std::fwrite(&count, sizeof(double), 1, file);
  std::fwrite(values.data(), sizeof(double), values.size(), file);
}

bool read(std::FILE* file, std::vector<double>& values) {
  double count = 0;
  if (std::fread(&count, sizeof(double), 1, file) != 1) return false;
  values.resize(static_cast<std::size_t>(count));
  return std::fread(values.data(), sizeof(double), values.size(), file) == values.size();
}

[[noreturn]] void work_and_end(const std::function<std::vector<std::vector<double>>()>& work, File file) {
  int status = 0;
  try {
    for (const std::vector<double>& values : work()) write(file.get(), values);
    file.reset();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    status = 1;
  }
  std::fflush(stderr);
  _exit(status);
}

}  // namespace

Apart run_apart(const std::function<std::vector<std::vector<double>>()>& work) {
  int ends[2];
  if (pipe(ends) != 0) throw Error(Failure::device, "run_apart", "there is no pipe to be had");
  std::fflush(stdout);
  const pid_t child = fork();
  if (child < 0) throw Error(Failure::device, "run_apart", "there is no process to be had");
  if (child == 0) {
    close(ends[0]);
    work_and_end(work, File(fdopen(ends[1], "wb")));
  }
  close(ends[1]);
  const File file(fdopen(ends[0], "rb"));
  Apart apart;
  for (std::vector<double> values; read(file.get(), values);) apart.values.push_back(std::move(values));
  int status = 0;
  rusage usage = {};
  wait4(child, &status, 0, &usage);
  if (status != 0) throw Error(Failure::device, "run_apart", "the work failed");
  apart.peak_memory = 1024.0 * static_cast<double>(usage.ru_maxrss);
  return apart;
}

}  // namespace lockstep::bench
