// From a scene's messages to the parameters of what is built.
#pragma once

#include "afferent/decoders/emg_gain.hpp"
#include "afferent/hand/gripper.hpp"
#include "afferent/hand/sensor.hpp"
#include "afferent/hand/user.hpp"
#include "afferent/neurons/parameters.hpp"
#include "afferent/neurons/tuning.hpp"
#include "afferent/proto/scene.pb.h"

namespace afferent {

NeuronParameters neuron_parameters(const proto::Neuron& neuron);
// The target in terms of one element, which feels `share` of the grip force.
TuningTarget tuning_target(const proto::Tuning& tuning, bool transient, double share);
Sensor::Parameters sensor_parameters(const proto::Sensor& sensor);
EmgGain::Parameters gain_parameters(const proto::Gain& gain);
Gripper::Parameters gripper_parameters(const proto::Hand& hand);
User::Parameters user_parameters(const proto::User& user);

}  // namespace afferent
