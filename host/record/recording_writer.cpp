#include "host/record/recording_writer.hpp"

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "host/error.hpp"
#include "host/record/recording_file.hpp"
#include "host/world_hash.hpp"

namespace lockstep {

// One batch is filled by the simulation while the other is written.
template <class real>
class RecordingWriter<real>::Thread {
 public:
  Thread(const std::string& path, const RecordingLabel& label, const InitialState<real>& start,
         const Recorded& recorded)
      : path_(path),
        file_(guarded([&] { return RecordingFile<real>(path, label, start, recorded); })),
        bodies_(start.sizes.bodies) {
    writes_ = true;
    thread_ = std::thread([this] { run(); });
  }
  ~Thread() {
    h5::be_quiet();  // each thread of a caller has to be
    stop();
  }

  void add(const StepRow& row, const Buffers<real>& buffers) {
    filling_.steps.push_back(row);
    ++position_.rows;
    for (const WorldHash& hash : buffers.world_hashes) {
      filling_.state_hashes.push_back(state_hash(hash));
      filling_.pose_hashes.push_back(pose_hash(hash));
    }
    const auto append = [&](auto& all, const auto& current) {
      all.insert(all.end(), current.begin(), current.begin() + bodies_);
    };
    append(filling_.positions, buffers.positions);
    append(filling_.orientations, buffers.orientations);
    append(filling_.motions, buffers.motions);
    if (filling_.steps.size() == file_.batch_steps()) hand_over();
  }
  void add(const RecordedForces& forces) {
    const auto append = [](auto& all, const auto& rows) { all.insert(all.end(), rows.begin(), rows.end()); };
    append(filling_.contact_forces, forces.contacts);
    append(filling_.joint_forces, forces.joints);
    contacts_ += forces.contacts.size();
    filling_.contact_ends.push_back(contacts_);
  }
  void add(const MeasureRow& row) { filling_.measures.push_back(row); }
  void add(const InputRow& row) {
    filling_.inputs.push_back(row);
    filling_.inputs.back().row = position_.rows;
    ++position_.inputs;
  }
  const RecordingPosition& position() const { return position_; }

  void close(const std::string& outcome) {
    hand_over();
    stop();
    if (failed_) std::rethrow_exception(failed_);
    writing([&] { file_.close(outcome); });
  }

 private:
  template <class Work>
  auto guarded(Work&& work) {
    h5::be_quiet();
    try {
      return work();
    } catch (const h5::Failed& failed) {
      throw Error(Failure::device, path_,
                  std::string("the recording cannot be written: ") + failed.what() +
                      (writes_ ? "; the steps that are there can be read" : ""));
    }
  }

  template <class Work>
  void writing(Work&& work) {
    try {
      guarded(work);
    } catch (const std::exception&) {
      file_.abandon();
      throw;
    }
  }

  void hand_over() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !busy_ || failed_; });
    if (failed_) std::rethrow_exception(failed_);
    std::swap(filling_, written_);
    filling_.clear();
    busy_ = true;
    changed_.notify_all();
  }

  void stop() {
    if (!thread_.joinable()) return;
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  void run() {
    h5::be_quiet();
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [&] { return busy_ || stopping_; });
      if (!busy_) return;
      lock.unlock();
      std::exception_ptr failed;
      try {
        writing([&] { file_.write(written_); });
      } catch (...) {
        failed = std::current_exception();
      }
      lock.lock();
      busy_ = false;
      failed_ = failed;
      changed_.notify_all();
      if (failed_) return;
    }
  }

  const std::string path_;
  bool writes_ = false;  // the file has its name
  RecordingFile<real> file_;
  const std::ptrdiff_t bodies_;
  Batch<real> filling_, written_;
  RecordingPosition position_;
  std::uint64_t contacts_ = 0;  // rows of contact_forces
  std::mutex mutex_;
  std::condition_variable changed_;
  bool busy_ = false, stopping_ = false;
  std::exception_ptr failed_;
  std::thread thread_;
};

template <class real>
RecordingWriter<real>::RecordingWriter(const std::string& path, const RecordingLabel& label,
                                       const InitialState<real>& start, const Recorded& recorded)
    : thread_(std::make_unique<Thread>(path, label, start, recorded)), has_forces_(recorded.forces) {}

template <class real>
RecordingWriter<real>::~RecordingWriter() {
  try {
    if (thread_) close("stopped");
  } catch (const std::exception&) {
  }
}

template <class real>
std::span<const Buffer> RecordingWriter<real>::wanted() {
  static constexpr Buffer buffers[] = {Buffer::world_hashes, Buffer::positions, Buffer::orientations, Buffer::motions};
  return buffers;
}

template <class real>
void RecordingWriter<real>::add(const StepRow& row, const Buffers<real>& buffers) {
  thread_->add(row, buffers);
}

template <class real>
void RecordingWriter<real>::add(const RecordedForces& forces) {
  thread_->add(forces);
}

template <class real>
void RecordingWriter<real>::add(const MeasureRow& row) {
  thread_->add(row);
}

template <class real>
void RecordingWriter<real>::add(const InputRow& row) {
  thread_->add(row);
}

template <class real>
RecordingPosition RecordingWriter<real>::position() const {
  return thread_->position();
}

template <class real>
void RecordingWriter<real>::close(const std::string& outcome) {
  const std::unique_ptr<Thread> thread = std::move(thread_);
  thread->close(outcome);
}

template class RecordingWriter<float>;
template class RecordingWriter<double>;

}  // namespace lockstep
