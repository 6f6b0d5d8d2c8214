! Abaqus/Explicit's VUINTER: the contact of a pair of surfaces, for all slave nodes of a call in place.
!
! Signs. Abaqus: rdisp(1, k) > 0 is penetration, stress(1, k) > 0 is pressure. Quoin: d_n > 0 opens, sigma > 0 is tension.
! Each is minus the other: both are negated in place for the evaluation and back after it, exactly. Sliding and shear have
! the same sign in both.
module quoin_slave_nodes
  use quoin_joints
  use quoin
  implicit none
contains

  subroutine move_slave_nodes(points, count, components, variables, rdisp, drdisp, stress, statev, sed, sfd, spd)
    type(joint), intent(in) :: points
    integer, intent(in) :: count, components, variables
    real(c_double), intent(inout), target :: rdisp(components, count)   ! as it was on return
    real(c_double), intent(in), target :: drdisp(components, count)
    real(c_double), intent(inout), target :: stress(components, count)  ! old in, new out
    real(c_double), intent(inout), target :: statev(variables, count)   ! old in, new out
    real(c_double), intent(inout), target :: sed(count), sfd(count), spd(count)
    real(c_double), target :: cohesion(count), crushing(count), no_slip, no_shear(count)  ! of two-dimensional contact
    type(quoin_column) :: states(max_states), slip(2), traction(3)
    integer :: k

    do k = 1, points%state_count
      states(k) = column(statev(k, 1), variables)
    end do
    call start_points(points, count, statev(points%state_count + 1, 1), variables, states)
    traction(1) = column(stress(1, 1), components)
    slip(1) = column(drdisp(2, 1), components)
    traction(2) = column(stress(2, 1), components)
    if (components == 3) then
      slip(2) = column(drdisp(3, 1), components)
      traction(3) = column(stress(3, 1), components)
    else
      no_slip = 0
      no_shear = 0
      slip(2) = column(no_slip, 0)
      traction(3) = column(no_shear(1), 1)
    end if
    rdisp(1, :) = -rdisp(1, :)
    stress(1, :) = -stress(1, :)
    call evaluate_block(points, count, column(rdisp(1, 1), components), slip, traction, traction, states, states, &
                        column(sed(1), 1), [column(spd(1), 1), column(cohesion(1), 1), column(sfd(1), 1), &
                                            column(crushing(1), 1)])
    rdisp(1, :) = -rdisp(1, :)
    stress(1, :) = -stress(1, :)
    if (points%energies) spd = spd + cohesion + crushing
  end subroutine

end module

subroutine vuinter(sfd, scd, spd, svd, stress, fluxSlv, fluxMst, sed, statev, kStep, kInc, nFacNod, nSlvNod, nMstNod, &
                   nSurfDir, nDir, nStateVar, nProps, nTemp, nPred, numDefTfv, jSlvUid, jMstUid, jConMstid, timStep, &
                   timGlb, dTimCur, surfInt, surfSlv, surfMst, rdisp, drdisp, drot, stiffDflt, condDflt, shape, &
                   coordSlv, coordMst, alocaldir, props, areaSlv, tempSlv, dtempSlv, preDefSlv, dpreDefSlv, tempMst, &
                   dtempMst, preDefMst, dpreDefMst)
  use quoin_slave_nodes
  use quoin_joints
  use quoin
  implicit none
  character(80) :: surfInt, surfSlv, surfMst
  integer :: kStep, kInc, nFacNod, nSlvNod, nMstNod, nSurfDir, nDir, nStateVar, nProps, nTemp, nPred, numDefTfv
  integer :: jSlvUid(*), jMstUid(*), jConMstid(*)
  real(c_double) :: stress(nDir, nSlvNod), statev(nStateVar, nSlvNod), rdisp(nDir, nSlvNod), drdisp(nDir, nSlvNod)
  real(c_double) :: sed(nSlvNod), sfd(nSlvNod), scd(nSlvNod), spd(nSlvNod), svd(nSlvNod), props(nProps)
  real(c_double) :: fluxSlv(*), fluxMst(*), timStep, timGlb, dTimCur, drot(*), stiffDflt(*), condDflt(*), shape(*), &
                    coordSlv(*), coordMst(*), alocaldir(*), areaSlv(*), tempSlv(*), dtempSlv(*), preDefSlv(*), &
                    dpreDefSlv(*), tempMst(*), dtempMst(*), preDefMst(*), dpreDefMst(*)
  type(joint), pointer :: points

  points => joint_of(trim(surfInt), props)
  call need_states(points, nStateVar, 1)
  call move_slave_nodes(points, nSlvNod, nDir, nStateVar, rdisp, drdisp, stress, statev, sed, sfd, spd)
end subroutine
