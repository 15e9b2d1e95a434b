#include "mapping/store/site_tables.hpp"

#include "mapping/store/map_tables.hpp"
#include "mapping/store/table_rows.hpp"

namespace ceilmap::store::tables {
namespace {

constexpr char kLeaveOneOut[] = "leave_one_out_m";  // null where it is not known

}  // namespace

OGRLayer* CreateControlPoints(GDALDataset& dataset, OGRSpatialReference& srs) {
  OGRLayer* layer = CreateTable(dataset, kControlPoints, &srs, wkbPoint, "fid");
  const bool done = layer != nullptr && AddField(*layer, "name", OFTString) &&
                    AddField(*layer, "site_x", OFTReal) && AddField(*layer, "site_y", OFTReal) &&
                    AddField(*layer, "sigma_m", OFTReal) &&
                    AddField(*layer, "residual_x_m", OFTReal) &&
                    AddField(*layer, "residual_y_m", OFTReal) &&
                    AddField(*layer, kLeaveOneOut, OFTReal) && AddField(*layer, "used", OFTInteger);
  return done ? layer : nullptr;
}

void Fill(OGRFeature& row, const survey::AlignedPoint& point) {
  row.SetField("name", point.point.name.c_str());
  row.SetField("site_x", point.point.p_site.x());
  row.SetField("site_y", point.point.p_site.y());
  row.SetField("sigma_m", point.point.sigma_m);
  row.SetField("residual_x_m", point.residual_m.x());
  row.SetField("residual_y_m", point.residual_m.y());
  if (point.leave_one_out_m) row.SetField(kLeaveOneOut, *point.leave_one_out_m);
  row.SetField("used", point.used ? 1 : 0);
  const OGRPoint place(point.point.p_map.x(), point.point.p_map.y());
  row.SetGeometry(&place);
}

bool Append(OGRLayer& layer, const survey::AlignedPoint& point) {
  const OGRFeatureUniquePtr row = NewRow(layer);
  Fill(*row, point);
  return AddRow(layer, *row);
}

survey::AlignedPoint ToAlignedPoint(OGRFeature& row) {
  survey::AlignedPoint point;
  point.point.name = Text(row, "name");
  point.point.p_site = {Real(row, "site_x"), Real(row, "site_y")};
  point.point.sigma_m = Real(row, "sigma_m");
  point.residual_m = {Real(row, "residual_x_m"), Real(row, "residual_y_m")};
  point.used = Integer(row, "used") != 0;
  const int left_out = row.GetFieldIndex(kLeaveOneOut);
  if (left_out >= 0 && row.IsFieldSetAndNotNull(left_out)) {
    point.leave_one_out_m = Real(row, kLeaveOneOut);
  }
  const OGRGeometry* geometry = row.GetGeometryRef();
  if (geometry == nullptr || wkbFlatten(geometry->getGeometryType()) != wkbPoint ||
      geometry->IsEmpty()) {
    ThrowDamaged(row, "no point");
  }
  point.point.p_map = {geometry->toPoint()->getX(), geometry->toPoint()->getY()};
  if (!point.point.p_map.allFinite()) ThrowDamaged(row, "position out of range");
  return point;
}

}  // namespace ceilmap::store::tables
