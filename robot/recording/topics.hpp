#pragma once

namespace kantaro::robot::topics {

// docs/recording.md describes each.
inline constexpr const char* kMission = "/mission";
inline constexpr const char* kFront = "/front";
inline constexpr const char* kStereoLeft = "/stereo/left";
inline constexpr const char* kStereoRight = "/stereo/right";
inline constexpr const char* kImage = "/image/compressed";  ///< of a camera
inline constexpr const char* kCameraInfo = "/camera_info";  ///< of a camera
inline constexpr const char* kScan = "/laser/scan";
inline constexpr const char* kLaser = "/laser/samples";
inline constexpr const char* kInfrared = "/infrared";
inline constexpr const char* kWheels = "/wheels";
inline constexpr const char* kInertial = "/imu";
inline constexpr const char* kInclination = "/inclination";
inline constexpr const char* kCompass = "/compass";
inline constexpr const char* kBattery = "/battery";
inline constexpr const char* kLoss = "/loss";
inline constexpr const char* kCommand = "/command";
inline constexpr const char* kPlace = "/estimate";
inline constexpr const char* kEstimate = "/estimate/leg";
inline constexpr const char* kEvent = "/event";

}  // namespace kantaro::robot::topics
