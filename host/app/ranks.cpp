#include "host/app/ranks.hpp"

#include <cstdlib>
#include <cstring>
#include <new>

#include "host/error.hpp"

#ifdef LOCKSTEP_MPI
#include <mpi.h>
#endif

namespace lockstep::app {

namespace {

// How many processes a launcher says that it started; Open MPI, MPICH and those that speak PMI say it so.
int launched() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MPI_LOCALNRANKS"})
    if (const char* size = std::getenv(name)) return std::atoi(size);
  return 1;
}

}  // namespace

#ifdef LOCKSTEP_MPI

namespace {

struct Failed {
  Failure failure;
  std::string line;
};

// What went wrong, as main() would tell it.
std::vector<Failed> failure_of(const std::function<void()>& work) {
  try {
    work();
    return {};
  } catch (const Error& error) {
    return {{error.failure(), error.what()}};
  } catch (const std::bad_alloc&) {
    return {{Failure::device, "out of memory; this machine needs fewer worlds, or more ranks"}};
  } catch (const std::exception& error) {
    return {{Failure::device, error.what()}};
  }
}

}  // namespace

Ranks::Ranks() {
  if (launched() <= 1) return;
  MPI_Init(nullptr, nullptr);
  joined_ = true;
  int rank = 0, size = 1, local_rank = 0, local_size = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  MPI_Comm here;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, rank, MPI_INFO_NULL, &here);
  MPI_Comm_rank(here, &local_rank);
  MPI_Comm_size(here, &local_size);
  MPI_Comm_free(&here);
  rank_ = static_cast<u32>(rank);
  size_ = static_cast<u32>(size);
  local_rank_ = static_cast<u32>(local_rank);
  local_size_ = static_cast<u32>(local_size);
}

Ranks::~Ranks() {
  if (joined_) MPI_Finalize();
}

void Ranks::together(const std::function<void()>& work) const {
  if (!joined_) return work();
  const std::vector<Failed> failed = failure_of(work);
  int first = failed.empty() ? static_cast<int>(size_) : static_cast<int>(rank_), of_all = 0;
  MPI_Allreduce(&first, &of_all, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
  if (of_all == static_cast<int>(size_)) return;
  int told[2] = {failed.empty() ? 0 : static_cast<int>(failed[0].failure),
                 failed.empty() ? 0 : static_cast<int>(failed[0].line.size())};
  MPI_Bcast(told, 2, MPI_INT, of_all, MPI_COMM_WORLD);
  std::string line(static_cast<std::size_t>(told[1]), ' ');
  if (of_all == static_cast<int>(rank_)) line = failed[0].line;
  MPI_Bcast(line.data(), told[1], MPI_CHAR, of_all, MPI_COMM_WORLD);
  if (rank_ > 0) throw SilentExit{told[0]};
  throw Error(static_cast<Failure>(told[0]), of_all == 0 ? "" : "rank " + std::to_string(of_all), line);
}

std::vector<std::string> Ranks::gather_bytes(const std::string& mine) const {
  if (!joined_) return {mine};
  // counts of bytes are ints to MPI: this is for hashes and figures
  const int count = static_cast<int>(mine.size());
  std::vector<int> counts(size_), starts(size_, 0);
  MPI_Gather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, MPI_COMM_WORLD);
  for (u32 r = 1; r < size_; ++r) starts[r] = starts[r - 1] + counts[r - 1];
  std::string all(rank_ == 0 ? static_cast<std::size_t>(starts.back() + counts.back()) : 0, '\0');
  MPI_Gatherv(mine.data(), count, MPI_CHAR, all.data(), counts.data(), starts.data(), MPI_CHAR, 0, MPI_COMM_WORLD);
  std::vector<std::string> chunks;
  for (u32 r = 0; rank_ == 0 && r < size_; ++r)
    chunks.push_back(all.substr(static_cast<std::size_t>(starts[r]), static_cast<std::size_t>(counts[r])));
  return chunks;
}

#else

Ranks::Ranks() {
  if (launched() > 1)
    throw Error(Failure::input, "mpirun",
                "has started several processes, and this build knows no MPI; build where MPI is found "
                "(libopenmpi-dev), or run it without");
}

Ranks::~Ranks() = default;

void Ranks::together(const std::function<void()>& work) const { work(); }

std::vector<std::string> Ranks::gather_bytes(const std::string& mine) const { return {mine}; }

#endif

}  // namespace lockstep::app
