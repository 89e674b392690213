#include "robot/urdf.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/robot/robot_files.hpp"

namespace kantaro::robot {
namespace {

// A slab of 2 x 4 x 6 m and 12 kg, sliding up a slope of its parent: every figure by hand.
constexpr const char* kSlider = R"(<robot name="slider">
  <link name="world"/>
  <link name="slab">
    <inertial><origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/><mass value="12"/>
      <inertia ixx="52" iyy="40" izz="20" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="2 4 6"/></geometry></collision>
    <visual><geometry><sphere radius="0.5"/></geometry></visual>
  </link>
  <joint name="slide" type="prismatic"><parent link="world"/><child link="slab"/>
    <origin xyz="0 0 1" rpy="0 0 3.141592653589793"/><axis xyz="0.6 0 0.8"/>
    <limit lower="-1" upper="2" effort="0" velocity="0"/></joint>
</robot>
)";

UrdfBody Slider() { return ParseUrdf({"slider.urdf", kSlider}); }

void ExpectRefused(const std::string& from, const std::string& to, const std::string& field,
                   const std::string& problem, std::optional<int> line) {
  try {
    (void)ParseUrdf({"slider.urdf", Edit(kSlider, from, to)});
    ADD_FAILURE() << "accepted: " << to;
  } catch (const InputError& error) {
    EXPECT_EQ(error.field(), field) << error.what();
    EXPECT_THAT(error.what(), ::testing::HasSubstr(problem));
    EXPECT_EQ(error.line(), line) << error.what();
  }
}

TEST(Urdf, ReadsLinksShapesAndJointsAsWritten) {
  const UrdfBody body = Slider();
  ASSERT_EQ(body.links.size(), 2U);
  ASSERT_EQ(body.joints.size(), 1U);
  EXPECT_FALSE(body.links[0].inertial.has_value());
  EXPECT_EQ(std::get<Box>(body.links[1].collisions.at(0).geometry).size_m,
            Eigen::Vector3d(2, 4, 6));
  EXPECT_EQ(std::get<Sphere>(body.links[1].visuals.at(0).geometry).radius_m, 0.5);
  const Joint& joint = body.joints[0];
  EXPECT_EQ(joint.type, JointType::kPrismatic);
  EXPECT_LT((joint.axis_J - Eigen::Vector3d(0.6, 0, 0.8)).norm(), 1e-12);
  EXPECT_EQ(joint.lower, -1.0);
  EXPECT_EQ(joint.upper, 2.0);
  EXPECT_LT((joint.X_PJ * Eigen::Vector3d::UnitX() - Eigen::Vector3d(-1, 0, 1)).norm(), 1e-12);
}

// The inertia is written in axes turned by 90 degrees about z: x and y change places in the link's.
TEST(Urdf, TurnsTheInertiaIntoTheLinksAxes) {
  const Inertial inertial = *Slider().links[1].inertial;
  EXPECT_EQ(inertial.p_LoLcm_L, Eigen::Vector3d(1, 2, 3));
  EXPECT_LT((inertial.I_LLcm_L - Eigen::Vector3d(40, 52, 20).asDiagonal().toDenseMatrix()).norm(),
            1e-9);
}

TEST(Urdf, RefusesNumbersThatAreNone) {
  ExpectRefused("mass value=\"12\"", "mass value=\"1,5\"",
                "robot[slider].link[slab].inertial.mass.value", "\"1,5\" is not a number", 4);
  ExpectRefused("mass value=\"12\"", "mass value=\"nan\"",
                "robot[slider].link[slab].inertial.mass.value", "\"nan\" is not a number", 4);
  ExpectRefused("size=\"2 4 6\"", "size=\"2 4\"",
                "robot[slider].link[slab].collision.geometry.box.size", "three numbers", 6);
}

TEST(Urdf, RefusesBodiesThatCannotBe) {
  ExpectRefused("radius=\"0.5\"", "radius=\"-0.5\"",
                "robot[slider].link[slab].visual.geometry.sphere.radius", "above 0", 7);
  ExpectRefused("value=\"12\"", "value=\"0\"", "robot[slider].link[slab].inertial.mass.value",
                "above 0", 4);
  ExpectRefused("ixx=\"52\"", "ixx=\"61\"", "link[slab].inertial.inertia", "sum of the other two",
                {});
  ExpectRefused("ixy=\"0\"", "ixy=\"46\"", "link[slab].inertial.inertia", "positive definite", {});
}

TEST(Urdf, RefusesElementsAndAttributesItDoesNotKnow) {
  ExpectRefused("<link name=\"world\"/>", "<link name=\"world\"><friction/></link>",
                "robot[slider].link[world].friction", "known here: inertial, collision, visual", 2);
  ExpectRefused("sphere radius", "sphere r=\"1\" radius",
                "robot[slider].link[slab].visual.geometry.sphere.r", "known here: radius", 7);
  ExpectRefused("<sphere radius=\"0.5\"/>", "<sphere radius=\"1\"/><box size=\"1 1 1\"/>",
                "robot[slider].link[slab].visual.geometry", "exactly one", 7);
  ExpectRefused("<mass value=\"12\"/>", "", "robot[slider].link[slab].inertial",
                "\"mass\" is missing", 4);
}

TEST(Urdf, RefusesJointsThatMakeNoTree) {
  ExpectRefused("child link=\"slab\"", "child link=\"slob\"", "joint[slide]", "no link \"slob\"",
                9);
  ExpectRefused("<link name=\"world\"/>", "<link name=\"world\"/><link name=\"stray\"/>", "robot",
                "3 links on 1 joints are not one tree", 1);
  ExpectRefused("child link=\"slab\"", "child link=\"world\"", "robot", "hangs on a ring", 1);
  ExpectRefused("<link name=\"world\"/>", "<link name=\"slab\"/>", "link[slab]", "second link", 3);
  ExpectRefused(
      "</robot>",
      "<joint name=\"again\" type=\"fixed\"><parent link=\"world\"/><child link=\"slab\"/></joint>"
      "</robot>",
      "joint[again]", "hangs on two joints", 12);
}

// world stands alone; a and b carry each other: as many joints as a tree would have.
TEST(Urdf, RefusesARingOfJoints) {
  ExpectRefused(
      "</robot>",
      "<link name=\"a\"/><link name=\"b\"/>"
      "<joint name=\"ab\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>"
      "<joint name=\"ba\" type=\"fixed\"><parent link=\"b\"/><child link=\"a\"/></joint></robot>",
      "robot", "hangs on a ring", 1);
}

TEST(Urdf, RefusesJointsThatSayTooLittle) {
  ExpectRefused("<axis xyz=\"0.6 0 0.8\"/>", "", "joint[slide]", "needs its axis", 9);
  ExpectRefused("xyz=\"0.6 0 0.8\"", "xyz=\"6 0 8\"", "robot[slider].joint[slide].axis.xyz",
                "length 1", 10);
  ExpectRefused("type=\"prismatic\"", "type=\"floating\"", "robot[slider].joint[slide].type",
                "unknown joint type", 9);
  ExpectRefused("lower=\"-1\"", "lower=\"3\"", "joint[slide]", "lower must be below upper", 11);
}

TEST(Urdf, RefusesTextThatIsNoXml) {
  ExpectRefused("</robot>", "", "", "not valid XML", 13);  // where the text ends
  ExpectRefused("<robot name", "<model name", "", "not valid XML", 12);
  ExpectRefused("<robot", "<!DOCTYPE x>\n<robot", "", "DOCTYPE", 1);
  ExpectRefused("slider", std::string(1, '\0'), "", "control character", 1);
  ExpectRefused("slider", "\xD7", "", "not UTF-8", 1);                   // a character's first half
  ExpectRefused("</robot>", "</robot>\n\xF0\x9F", "", "not UTF-8", 13);  // cut off by the end
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "<link name=\"a\">";
  ExpectRefused("<link name=\"world\"/>", deep, "", "nested deeper", 2);
}

TEST(Urdf, ReadsTheShippedRobotWithoutPrinting) {
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(ParseUrdf(Shipped("kantaro.urdf")).links.size(), 22U);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace kantaro::robot
