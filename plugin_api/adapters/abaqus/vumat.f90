! Abaqus/Explicit's VUMAT for cohesive elements with a traction-separation response, for all points of a call in place.
!
! Signs and units. Stress (n, s, t) and separation are Quoin's traction and jump, tension and opening positive: nothing is
! converted. Strains are separations as long as the section's thickness is the specified one, 1. VUMAT tells increments
! alone: the separation d_n is summed in a state variable.
module quoin_cohesive_elements
  use quoin_joints
  use quoin
  implicit none
contains

  subroutine move_cohesive_points(points, count, variables, density, strainInc, stressOld, stateOld, enerInelasOld, &
                                  stressNew, stateNew, enerInternNew, enerInelasNew)
    type(joint), intent(in) :: points
    integer, intent(in) :: count, variables
    real(c_double), intent(in), target :: strainInc(count, 3), stressOld(count, 3), stateOld(count, variables)
    real(c_double), intent(in) :: density(count), enerInelasOld(count)
    real(c_double), intent(inout), target :: stressNew(count, 3), stateNew(count, variables)
    real(c_double), intent(inout), target :: enerInternNew(count), enerInelasNew(count)
    real(c_double), target :: dissipated(count, 4)
    type(quoin_column) :: old(max_states), new(max_states)
    integer :: k, started, separation

    started = points%state_count + 1
    separation = points%state_count + 2
    do k = 1, points%state_count
      old(k) = column(stateOld(1, k), 1)
      new(k) = column(stateNew(1, k), 1)
    end do
    if (any(stateOld(:, started) < 0.5)) then
      stateNew = stateOld
      call start_points(points, count, stateNew(1, started), 1, new)
      old = new
    end if
    stateNew(:, started) = 1
    stateNew(:, separation) = stateOld(:, separation) + strainInc(:, 1)
    call evaluate_block(points, count, column(stateNew(1, separation), 1), &
                        [(column(strainInc(1, k), 1), k = 2, 3)], [(column(stressOld(1, k), 1), k = 1, 3)], &
                        [(column(stressNew(1, k), 1), k = 1, 3)], old, new, column(enerInternNew(1), 1), &
                        [(column(dissipated(1, k), 1), k = 1, 4)])
    if (.not. points%energies) return
    enerInelasNew = enerInelasOld + sum(dissipated, dim=2) / density
    enerInternNew = enerInternNew / density + enerInelasNew
  end subroutine

end module

subroutine vumat(nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal, stepTime, totalTime, dt, cmname, coordMp, &
                 charLength, props, density, strainInc, relSpinInc, tempOld, stretchOld, defgradOld, fieldOld, &
                 stressOld, stateOld, enerInternOld, enerInelasOld, tempNew, stretchNew, defgradNew, fieldNew, &
                 stressNew, stateNew, enerInternNew, enerInelasNew)
  use quoin_cohesive_elements
  use quoin_joints
  use quoin
  implicit none
  character(80) :: cmname
  integer :: nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal
  real(c_double) :: stepTime, totalTime, dt, props(nprops), density(nblock)
  real(c_double) :: strainInc(nblock, ndir + nshr), stressOld(nblock, ndir + nshr), stressNew(nblock, ndir + nshr)
  real(c_double) :: stateOld(nblock, nstatev), stateNew(nblock, nstatev)
  real(c_double) :: enerInternOld(nblock), enerInelasOld(nblock), enerInternNew(nblock), enerInelasNew(nblock)
  real(c_double) :: coordMp(*), charLength(*), relSpinInc(*), tempOld(*), stretchOld(*), defgradOld(*), fieldOld(*), &
                    tempNew(*), stretchNew(*), defgradNew(*), fieldNew(*)
  type(joint), pointer :: points

  points => joint_of(trim(cmname), props)
  call need_states(points, nstatev, 2)
  if (ndir + nshr /= 3) call refuse(points%name, "give it to three-dimensional cohesive elements: COH3D8, COH3D6")
  if (stepTime <= 0 .and. totalTime <= 0) then  ! Abaqus asks for the elastic stiffness by invented strains
    stressNew(:, 1) = stressOld(:, 1) + points%stiffness%normal * strainInc(:, 1)
    stressNew(:, 2:3) = stressOld(:, 2:3) + points%stiffness%shear * strainInc(:, 2:3)
    return
  end if
  call move_cohesive_points(points, nblock, nstatev, density, strainInc, stressOld, stateOld, enerInelasOld, &
                            stressNew, stateNew, enerInternNew, enerInelasNew)
end subroutine
