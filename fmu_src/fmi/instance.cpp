#include "fmi/instance.h"

#include <new>

#include "fmi/model.h"
#include "fmi/resources.h"
#include "model/modal_file.h"
#include "text/text.h"

namespace sigmafmu {
namespace {

const char* name_of(Phase phase) {
  switch (phase) {
    case Phase::instantiated:
      return "instantiated";
    case Phase::initialization:
      return "initialization mode";
    case Phase::step:
      return "step mode";
    default:
      return "terminated";
  }
}

}  // namespace

Status report_exception(const Logger& logger, const char* instance, Status when_discarded) noexcept {
  try {
    throw;
  } catch (const Discarded& e) {
    logger.write(instance, when_discarded, when_discarded == Status::error ? kError : kDiscard, e.what());
    return when_discarded;
  } catch (const std::bad_alloc&) {
    logger.write(instance, Status::error, kError, kNoMemory);
  } catch (const std::exception& e) {
    logger.write(instance, Status::error, kError, e.what());
  } catch (...) {
    logger.write(instance, Status::error, kError, "An error without a description.");
  }
  return Status::error;
}

Instance::Instance(const char* name, std::unique_ptr<const Logger> logger, Mechanism mechanism, const char* identity,
                   bool logs_events)
    : name_(name),
      logger_(std::move(logger)),
      logs_events_(logs_events),
      slave_(std::move(mechanism), identity, this) {}

void Instance::require_phase(const char* function, unsigned allowed) const {
  const Phase phase = slave_.phase();
  if (allowed & mask(phase)) return;
  fail<Refused>(function, " is not allowed in the state \"", name_of(phase), "\".");
}

Status Instance::do_step(double t, double H) {
  if (slave_.do_step(t, H)) return Status::ok;
  logger_->write(name(), Status::discard, kDiscard, slave_.message());
  return Status::discard;
}

std::unique_ptr<Instance> instantiate(const char* name, std::unique_ptr<const Logger> logger, const char* guid,
                                      const char* resources, bool logs_events) {
  Model model = make_model(resources);
  if (!guid || model.guid != guid) fail<Refused>("The GUID does not fit; it must be ", model.guid, ".");
  const auto files = modal_files(model.mechanism);
  if (!files.empty()) {  // only such mechanisms look at the resource location
    model.resources = load_modal_files(model.mechanism, resources_folder(resources, files[0]), model.resources);
  }
  // A state belongs to the numbers that were read, too.
  const bool has_read = model.resources != kNoChecksum;
  const std::string identity = (has_read ? hexadecimal(model.resources) : "") + model.guid;
  auto instance = std::make_unique<Instance>(name, std::move(logger), model.mechanism, identity.c_str(), logs_events);
  if (!model.variables.empty() && model.variables != variables_checksum(instance->slave().variables())) {
    throw Refused("The mechanism has other variables than modelDescription.xml; the FMU must be built again.");
  }
  return instance;
}

}  // namespace sigmafmu
