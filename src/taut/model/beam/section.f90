!> Cross sections of beams: stiffness and inertia per unit length.
!!
!! Local axes: 1 along the beam, 2 and 3 across, the principal axes of a section's inertia. Strains are {axial, shear 2,
!! shear 3, torsion, curvature about 2, curvature about 3}; forces {N, Q2, Q3, T, M2, M3} in the same order.
module taut_model_beam_section
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_linalg_lapack, only: dpotrf, dpotrs
   use taut_rotation, only: skew
   implicit none (type, external)
   private
   public :: beam_section_t, new_section, rectangular_section, corrected_stiffness

   !> A section.
   type :: beam_section_t
      !> Forces per strain: [N], [N m] and [N m^2].
      real(wp) :: stiffness(6, 6) = 0.0_wp
      !> Mass per unit length [kg/m].
      real(wp) :: mass = 0.0_wp
      !> Moments of inertia per unit length about axes 1, 2, 3 [kg m].
      real(wp) :: inertia(3) = 0.0_wp
   end type beam_section_t

   character(*), parameter :: here = 'beam section'

contains

   !> A section of any stiffness.
   subroutine new_section(section, stiffness, mass, inertia, error)
      !> The section.
      type(beam_section_t), intent(out) :: section
      !> Symmetric positive definite.
      real(wp), intent(in) :: stiffness(6, 6)
      !> Mass per unit length [kg/m].
      real(wp), intent(in) :: mass
      !> Moments of inertia per unit length about axes 1, 2, 3 [kg m].
      real(wp), intent(in) :: inertia(3)
      !> A value that makes no sense.
      type(error_t), allocatable, intent(inout) :: error
      real(wp) :: compliance(6, 6)
      integer :: info

      if (.not. all(abs(stiffness) <= huge(1.0_wp))) then
         call raise(error, here, 'an entry of the stiffness is not a number', 'give 36 numbers')
      else if (any(abs(stiffness - transpose(stiffness)) > 1.0e-12_wp*maxval(abs(stiffness)))) then
         call raise(error, here, 'the stiffness is not symmetric', 'give equal entries on both sides of the diagonal')
      else
         call invert(stiffness, compliance, info)
         if (info /= 0) call raise(error, here, 'the stiffness is not positive definite: row '//to_text(info), &
                                   'give a section that resists every strain')
      end if
      if (.not. (mass > 0.0_wp .and. mass <= huge(mass))) &
         call raise(error, here, 'the mass per unit length, '//to_text(mass)//', is not positive', 'give it in kg/m')
      if (.not. all(inertia > 0.0_wp .and. inertia <= huge(1.0_wp))) &
         call raise(error, here, 'a moment of inertia per unit length is not positive', 'give three numbers in kg m')
      if (allocated(error)) return
      section%stiffness = stiffness
      section%mass = mass
      section%inertia = inertia
   end subroutine new_section

   !> A solid rectangle of an isotropic material; the shear factor is 5/6.
   subroutine rectangular_section(section, young, poisson, density, size_2, size_3, error)
      !> The section.
      type(beam_section_t), intent(out) :: section
      !> Young's modulus [Pa].
      real(wp), intent(in) :: young
      !> Poisson's ratio.
      real(wp), intent(in) :: poisson
      !> Density [kg/m^3].
      real(wp), intent(in) :: density
      !> Side along local axis 2 [m].
      real(wp), intent(in) :: size_2
      !> Side along local axis 3 [m].
      real(wp), intent(in) :: size_3
      !> A value that makes no sense.
      type(error_t), allocatable, intent(inout) :: error
      real(wp) :: area, i_2, i_3, shear, stiffness(6, 6)
      integer :: i

      call positive('Young''s modulus', young, 'give it in Pa')
      call positive('density', density, 'give it in kg/m^3')
      call positive('side along axis 2', size_2, 'give it in m')
      call positive('side along axis 3', size_3, 'give it in m')
      if (.not. (poisson > -1.0_wp .and. poisson <= 0.5_wp)) &
         call raise(error, here, 'Poisson''s ratio = '//to_text(poisson)//' is not between -1 and 1/2', &
                    'give a ratio such as 0.3')
      if (allocated(error)) return
      area = size_2*size_3
      i_2 = size_2*size_3**3/12.0_wp
      i_3 = size_3*size_2**3/12.0_wp
      shear = young/(2.0_wp*(1.0_wp + poisson))
      stiffness = 0.0_wp
      do i = 2, 3
         stiffness(i, i) = 5.0_wp/6.0_wp*shear*area
      end do
      stiffness(1, 1) = young*area
      stiffness(4, 4) = shear*torsion_constant(size_2, size_3)
      stiffness(5, 5) = young*i_2
      stiffness(6, 6) = young*i_3
      call new_section(section, stiffness, density*area, density*[i_2 + i_3, i_2, i_3], error)

   contains

      subroutine positive(name, value, remedy)
         character(*), intent(in) :: name, remedy
         real(wp), intent(in) :: value

         if (.not. (value > 0.0_wp .and. value <= huge(value))) &
            call raise(error, here, name//' = '//to_text(value)//' is not positive', remedy)
      end subroutine positive

   end subroutine rectangular_section

   !> Torsion constant of a rectangle [m^4]: a b^3/3 (1 - 192 b/(pi^5 a) sum over odd n of tanh(n pi a/(2 b))/n^5), a >= b.
   !!
   !! Source: S.P. Timoshenko, J.N. Goodier, Theory of Elasticity, 3rd ed., 1970, Sect. 109.
   pure function torsion_constant(size_2, size_3) result(j)
      real(wp), intent(in) :: size_2, size_3
      real(wp) :: j
      real(wp), parameter :: pi = acos(-1.0_wp)
      real(wp) :: a, b, series
      integer :: n

      a = max(size_2, size_3)
      b = min(size_2, size_3)
      series = 0.0_wp
      do n = 201, 1, -2
         series = series + tanh(0.5_wp*n*pi*a/b)/real(n, wp)**5
      end do
      j = a*b**3/3.0_wp*(1.0_wp - 192.0_wp*b/(pi**5*a)*series)
   end function torsion_constant

   !> The stiffness for elements of one length: the shear compliance has l^2/12 (e1 x)^T C (e1 x) added, C the bending
   !! compliance. In the plane that is 1/GA* = 1/GA + l^2/(12 EI).
   !!
   !! Source: the residual shear locking at the end of the paper's Appendix. A two-node element has constant curvature; the
   !! correction makes its compliance to end loads that of the cubic.
   subroutine corrected_stiffness(section, l, stiffness)
      !> The section.
      type(beam_section_t), intent(in) :: section
      !> Length of an element [m].
      real(wp), intent(in) :: l
      !> What the element is to use.
      real(wp), intent(out) :: stiffness(6, 6)
      real(wp) :: compliance(6, 6), e1(3, 3)
      integer :: info

      e1 = skew([1.0_wp, 0.0_wp, 0.0_wp])
      call invert(section%stiffness, compliance, info)
      compliance(1:3, 1:3) = compliance(1:3, 1:3) + &
                             l*l/12.0_wp*matmul(transpose(e1), matmul(compliance(4:6, 4:6), e1))
      call invert(compliance, stiffness, info)
   end subroutine corrected_stiffness

   !> Inverse of a symmetric positive definite matrix, symmetric to the last bit.
   subroutine invert(k, inverse, info)
      real(wp), intent(in) :: k(6, 6)
      real(wp), intent(out) :: inverse(6, 6)
      integer, intent(out) :: info
      real(wp) :: factor(6, 6), scale(6)
      integer :: i

      inverse = 0.0_wp
      do i = 1, 6
         info = i
         if (.not. k(i, i) > 0.0_wp) return
         scale(i) = 1.0_wp/sqrt(k(i, i))
         inverse(i, i) = 1.0_wp
      end do
      do i = 1, 6
         factor(:, i) = scale*k(:, i)*scale(i)
      end do
      call dpotrf('L', 6, factor, 6, info)
      if (info /= 0) return
      call dpotrs('L', 6, 6, factor, 6, inverse, 6, info)
      do i = 1, 6
         inverse(:, i) = scale*inverse(:, i)*scale(i)
      end do
      inverse = 0.5_wp*(inverse + transpose(inverse))
   end subroutine invert

end module taut_model_beam_section
