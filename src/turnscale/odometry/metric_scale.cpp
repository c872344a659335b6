// SPDX-License-Identifier: MIT
#include "turnscale/odometry/metric_scale.h"

namespace turnscale {

MetricScale::MetricScale(const OdometryOptions& options) : options_(options), detector_(options.turns) {}

ScaleUpdate MetricScale::AddKeyframe(Map&) { return {}; }
ScaleUpdate MetricScale::Finish(Map&) { return {}; }
std::vector<TurnResult> MetricScale::Turns(const Map&) const { return turns_; }
void MetricScale::Annotate(const Map&, std::vector<FrameResult>&) const {}

}  // namespace turnscale
